# Highway compiles these once for each vector unit: they include themselves.
set(livermark_vector_msm_sources kernels/energies/hooke.cpp kernels/energies/neo_hookean.cpp
  kernels/simd/scaled_mass_steps.cpp kernels/simd/take_steps.cpp)
# Sources that also run where there are no threads and no CHOLMOD: see cmake/portable.cmake.
set(livermark_portable_msm_sources springs/tetrahedron.cpp springs/coupled_springs.cpp
  elastic_body.cpp springs/spring_network.cpp springs/volume_penalty.cpp springs/capsule.cpp springs/vessels.cpp
  springs/foundation.cpp dynamics/time_step.cpp dynamics/mass_scaling.cpp kernels/fast_steps.cpp kernels/step_workspace.cpp
  kernels/layout/sliced_fans.cpp kernels/layout/sliced_nodal_springs.cpp
  kernels/layout/sliced_body.cpp kernels/layout/sliced_springs.cpp kernels/layout/sliced_edges.cpp
  kernels/layout/new_volumes.cpp kernels/layout/new_chunk.cpp kernels/relaxation.cpp
  cutting/cut_parts.cpp cutting/around_cut.cpp dynamics/spring_stepper.cpp kernels/thread_pool.cpp ${livermark_vector_msm_sources})
