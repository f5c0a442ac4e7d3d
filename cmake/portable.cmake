# livermark_portable_sources(<target> <top>)
# Compiles what moves the springs of the live page into a target: the same lines for WebAssembly and for the build that a
# test holds it against. Neither has threads or CHOLMOD, and their numbers are the same to the last bit: sums in one order,
# no fused multiplications, exact roots, and vectors of 16 bytes, because how long they are tells the order in which forces
# are added up.
include(extensions)
function(livermark_portable_sources target top)
  include(${top}/app/live/sources.cmake)
  include(${top}/msm/sources.cmake)
  list(TRANSFORM livermark_live_sources PREPEND ${top}/app/live/)
  list(TRANSFORM livermark_portable_msm_sources PREPEND ${top}/msm/)
  target_sources(${target} PRIVATE ${livermark_live_sources} ${livermark_portable_msm_sources}
    ${top}/meshes/cutting/parting.cpp ${top}/meshes/cutting/tool_geometry.cpp
    ${top}/core/mesh/tetra_mesh.cpp ${top}/core/capsule.cpp ${top}/core/vessels.cpp
    ${top}/core/tool/least_within_limits.cpp
    ${top}/core/tool/needle/moving_needle.cpp
    ${top}/core/tool/ball_contact.cpp ${top}/core/tool/touching_tool.cpp ${top}/core/tool/tool_motion.cpp ${top}/core/load_case.cpp
    ${top}/core/mesh/places.cpp ${top}/core/relaxation.cpp ${top}/core/support/input_error.cpp)
  set(CMAKE_CURRENT_SOURCE_DIR ${top}/msm)
  livermark_extensions(${target} spring_laws TYPE SpringLaw HEADER msm/spring_law.hpp)
  livermark_extensions(${target} spring_energies TYPE SpringEnergy HEADER msm/spring_energy.hpp)
  livermark_extensions(${target} integrators TYPE Integrator HEADER msm/integrator.hpp)
  livermark_extensions(${target} volume_terms TYPE VolumeTerm HEADER msm/spring_law.hpp)
  target_include_directories(${target} PRIVATE ${top})
  target_compile_definitions(${target} PRIVATE HWY_COMPILE_ONLY_STATIC LIVERMARK_EXACT_ROOTS
    LIVERMARK_WITHOUT_EQUILIBRIA LIVERMARK_WITHOUT_THREADS
    EIGEN_DONT_VECTORIZE FMT_HEADER_ONLY NDEBUG)
  target_compile_options(${target} PRIVATE -ffp-contract=off)
  list(TRANSFORM livermark_vector_msm_sources PREPEND ${top}/msm/)
  set_source_files_properties(${livermark_vector_msm_sources} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
