# What also runs where there are no threads and no CHOLMOD: see cmake/portable.cmake.
set(livermark_portable_msm_sources bounded_least_squares.cpp springs/linear_elements.cpp springs/coupled_springs.cpp springs/edge_stretches.cpp
  elastic_body.cpp integrator.cpp springs/inversion_guard.cpp springs/law_of_tetrahedra.cpp
  mass_lumping.cpp springs/mean_parts.cpp springs/nodal_parts.cpp springs/spring_network.cpp springs/springs_with_volume.cpp springs/strain_measures.cpp springs/tetrahedron_volume.cpp springs/volume_penalty.cpp
  dynamics/chebyshev_stages.cpp dynamics/highest_frequency.cpp dynamics/mass_scaling.cpp dynamics/step_parts.cpp dynamics/time_step.cpp
  statics/free_components.cpp
  kernels/fast_steps.cpp kernels/make_workspace.cpp kernels/layout/fans.cpp kernels/layout/mean_gradients.cpp kernels/layout/node_order.cpp kernels/layout/sliced_body.cpp
  kernels/layout/sliced_fans.cpp kernels/layout/sliced_nodal_springs.cpp kernels/layout/sliced_shapes.cpp
  kernels/layout/sliced_springs.cpp kernels/layout/sliced_stars.cpp kernels/layout/spring_lanes.cpp kernels/layout/stars.cpp
  kernels/layout/sliced_update.cpp kernels/layout/volume_means.cpp kernels/layout/parting/add_rows.cpp kernels/layout/parting/new_chunk.cpp
  kernels/layout/parting/new_volumes.cpp kernels/layout/parting/force_sums.cpp kernels/layout/parting/parted_springs.cpp kernels/layout/parting/part_sliced_body.cpp
  kernels/relaxation/relaxation_arrays.cpp kernels/relaxation/relaxation_clock.cpp
  kernels/simd/relax_stresses.cpp kernels/simd/scaled_mass_parts.cpp kernels/simd/take_steps.cpp
  kernels/threads/partition.cpp cutting/cut_parts.cpp cutting/part_parts.cpp cutting/kept_numbers.cpp cutting/frequency_around.cpp cutting/part_of_body.cpp needle/moving_needle.cpp)
