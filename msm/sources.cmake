# What also runs where there are no threads and no CHOLMOD: see cmake/portable.cmake.
set(livermark_portable_msm_sources bounded_least_squares.cpp chebyshev_stages.cpp elastic_body.cpp free_components.cpp highest_frequency.cpp
  integrator.cpp inversion_guard.cpp kernels/fans.cpp kernels/fast_steps.cpp kernels/node_order.cpp kernels/shares.cpp
  kernels/sliced_body.cpp kernels/sliced_fans.cpp kernels/sliced_nodal_springs.cpp kernels/sliced_shapes.cpp
  kernels/sliced_springs.cpp kernels/spring_lanes.cpp kernels/take_steps.cpp mass_lumping.cpp nodal_parts.cpp spring_network.cpp springs_with_volume.cpp step_parts.cpp
  tetrahedron_volume.cpp time_step.cpp volume_penalty.cpp)
