# Installs what other programs link, in three components that each need those before them, and the Python package, whose
# components python/CMakeLists.txt installs:
#   core            mesh, material, load case, solution; needs Eigen and fmt
#   msm             spring laws, volume terms, kernels, critical steps, damping; needs Highway as well
#   fem_reference   finite elements, and what of mass-spring models needs sparse factors; deal.II, CHOLMOD and so the GPL
# An outsider writes find_package(Livermark COMPONENTS msm), target_link_libraries(theirs livermark::msm) and
# #include <livermark/msm/spring_law.hpp>. Headers of this tree include each other without the livermark/ in front, which is
# put there on the way.
include(CMakePackageConfigHelpers)

# Headers of a folder and those below it, without what is internal.
function(livermark_install_headers component folder)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "" "ONLY;EXCEPT")
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${livermark_SOURCE_DIR}/${folder}
    ${livermark_SOURCE_DIR}/${folder}/*.hpp)
  foreach(header IN LISTS headers)
    set(is_wanted ON)
    if(arg_ONLY)
      set(is_wanted OFF)
    endif()
    foreach(pattern IN LISTS arg_ONLY)
      if(header MATCHES "${pattern}")
        set(is_wanted ON)
      endif()
    endforeach()
    foreach(pattern IN LISTS arg_EXCEPT)
      if(header MATCHES "${pattern}")
        set(is_wanted OFF)
      endif()
    endforeach()
    if(NOT is_wanted)
      continue()
    endif()
    # For programs that add this tree as a subdirectory.
    file(CONFIGURE OUTPUT ${livermark_BINARY_DIR}/include/livermark/${folder}/${header}
      CONTENT "#include \"${livermark_SOURCE_DIR}/${folder}/${header}\"\n")
    cmake_path(GET header PARENT_PATH below)
    install(CODE "
      file(READ \"${livermark_SOURCE_DIR}/${folder}/${header}\" text)
      string(REGEX REPLACE \"#include \\\"([a-z_]+/)\" \"#include \\\"livermark/\\\\1\" text \"\${text}\")
      file(WRITE \"${livermark_BINARY_DIR}/installed/${folder}/${header}\" \"\${text}\")" COMPONENT ${component})
    install(FILES ${livermark_BINARY_DIR}/installed/${folder}/${header}
      DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/livermark/${folder}/${below} COMPONENT ${component})
  endforeach()
endfunction()

# Headers of livermark_msm_solvers.
set(factorising_statics "(statics/(dynamic|equilibrium|load_path|rest|surface_)|dynamics/histories)")
livermark_install_headers(core core/support ONLY "^input_error")
livermark_install_headers(core core EXCEPT "^support/")
livermark_install_headers(msm msm
  EXCEPT "-inl" "^kernels/(layout|simd)/" "^kernels/(relaxation|step_workspace|thread_pool|vector_springs)" "^implicit"
    "${factorising_statics}")
set(components core msm)
if(LIVERMARK_WITH_FEM_REFERENCE)
  list(APPEND components fem_reference)
  livermark_install_headers(fem_reference msm
    ONLY "^implicit" "${factorising_statics}")
  livermark_install_headers(fem_reference core/support ONLY "^(factors/sparse_cholesky|processes/mpi_session)")
  livermark_install_headers(fem_reference fem_reference)
endif()

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/Livermark)
foreach(component IN LISTS components)
  install(EXPORT livermark_${component} NAMESPACE livermark:: FILE Livermark-${component}.cmake DESTINATION ${package}
    COMPONENT ${component})
endforeach()
configure_package_config_file(${livermark_SOURCE_DIR}/cmake/LivermarkConfig.cmake.in LivermarkConfig.cmake
  INSTALL_DESTINATION ${package})
write_basic_package_version_file(LivermarkConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${livermark_BINARY_DIR}/LivermarkConfig.cmake ${livermark_BINARY_DIR}/LivermarkConfigVersion.cmake
  DESTINATION ${package} COMPONENT core)
foreach(component core msm)
  install(FILES ${livermark_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR}-${component} COMPONENT ${component})
endforeach()
if(LIVERMARK_WITH_FEM_REFERENCE)
  install(FILES ${livermark_SOURCE_DIR}/cmake/finite_elements.cmake DESTINATION ${package} COMPONENT fem_reference)
  install(FILES ${livermark_SOURCE_DIR}/LICENSE ${livermark_SOURCE_DIR}/NOTICE
    DESTINATION ${CMAKE_INSTALL_DOCDIR}-fem-reference COMPONENT fem_reference)
endif()

if(NOT PROJECT_IS_TOP_LEVEL)
  return()
endif()
# The program, in a folder of its own that is laid out as the source tree, so that it finds what it reads beside itself.
if(LIVERMARK_WITH_FEM_REFERENCE)
  set(tree lib/livermark)
  install(TARGETS livermark RUNTIME DESTINATION ${tree} COMPONENT program)
  if(TARGET livermark-segment)
    install(TARGETS livermark-segment RUNTIME DESTINATION ${tree} COMPONENT program)
  endif()
  file(MAKE_DIRECTORY ${livermark_BINARY_DIR}/installed/bin)
  file(CREATE_LINK ../${tree}/livermark ${livermark_BINARY_DIR}/installed/bin/livermark SYMBOLIC)
  install(FILES ${livermark_BINARY_DIR}/installed/bin/livermark DESTINATION bin COMPONENT program)
  file(GLOB_RECURSE load_cases CONFIGURE_DEPENDS RELATIVE ${livermark_SOURCE_DIR} ${livermark_SOURCE_DIR}/load_cases/*.toml)
  file(GLOB files CONFIGURE_DEPENDS RELATIVE ${livermark_SOURCE_DIR} ${livermark_SOURCE_DIR}/meshes/*.toml
    ${livermark_SOURCE_DIR}/meshes/*.msh ${livermark_SOURCE_DIR}/results/*.toml ${livermark_SOURCE_DIR}/results/cohorts/*.toml
    ${livermark_SOURCE_DIR}/results/engines/*.json)
  foreach(file IN LISTS load_cases files)
    cmake_path(GET file PARENT_PATH place)
    install(FILES ${livermark_SOURCE_DIR}/${file} DESTINATION ${tree}/${place} COMPONENT program)
  endforeach()
  install(DIRECTORY ${livermark_SOURCE_DIR}/results/references ${livermark_SOURCE_DIR}/results/cohorts DESTINATION ${tree}/results
    COMPONENT program FILES_MATCHING PATTERN "*.h5")
  install(PROGRAMS ${livermark_SOURCE_DIR}/scripts/convert_mesh ${livermark_SOURCE_DIR}/scripts/convert_solution
    ${livermark_SOURCE_DIR}/scripts/convert_surface DESTINATION ${tree}/scripts COMPONENT program)
  install(FILES ${livermark_SOURCE_DIR}/app/viewer/dist/index.html DESTINATION ${tree}/app/viewer/dist COMPONENT program OPTIONAL)
  install(FILES ${livermark_SOURCE_DIR}/NOTICE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
  list(APPEND components program)
endif()

# Debian packages, one for each component: cpack -G DEB in the build folder, or scripts/package.
set(CPACK_PACKAGE_CONTACT "The Livermark authors <authors@livermark.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_RESOURCE_FILE_LICENSE ${livermark_SOURCE_DIR}/LICENSE)
set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_COMPONENTS_ALL ${components})
if(TARGET _livermark)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
if(TARGET _suite)
  list(APPEND CPACK_COMPONENTS_ALL python_suite)
endif()
set(CPACK_COMPONENT_CORE_DESCRIPTION "Mesh, material, load case and solution of Livermark. Licence: Apache-2.0 alone.")
set(CPACK_COMPONENT_MSM_DESCRIPTION
  "Mass-spring models of Livermark: spring laws, volume terms, vector kernels, critical time steps. Licence: Apache-2.0 alone.")
set(CPACK_COMPONENT_FEM_REFERENCE_DESCRIPTION
  "Finite elements of Livermark and what needs sparse factors. Linked with CHOLMOD a program is under the GPL, see NOTICE.")
set(CPACK_DEBIAN_CORE_PACKAGE_NAME livermark-core-dev)
set(CPACK_DEBIAN_MSM_PACKAGE_NAME livermark-msm-dev)
set(CPACK_DEBIAN_FEM_REFERENCE_PACKAGE_NAME livermark-fem-reference-dev)
set(CPACK_DEBIAN_CORE_PACKAGE_DEPENDS "libeigen3-dev, libfmt-dev")
set(CPACK_DEBIAN_MSM_PACKAGE_DEPENDS "livermark-core-dev, libhwy-dev")
set(CPACK_DEBIAN_FEM_REFERENCE_PACKAGE_DEPENDS
  "livermark-msm-dev, libdeal.ii-dev, libsuitesparse-dev, libblas-dev, libspectra-dev")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION
  "Springs of Livermark, their motion, and its result files in Python. Licence: Apache-2.0 alone.")
set(CPACK_COMPONENT_PYTHON_SUITE_DESCRIPTION
  "Problems, models and the reference of Livermark in Python. Linked with CHOLMOD and gmsh, and so under the GPL, see NOTICE.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-livermark)
set(CPACK_DEBIAN_PYTHON_SUITE_PACKAGE_NAME python3-livermark-suite)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "${LIVERMARK_PYTHON_VERSION}, python3-numpy, python3-h5py")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS
  "python3-pandas, python3-scipy, python3-vtk9, python3-matplotlib, python3-jinja2, python3-livermark-suite")
set(CPACK_DEBIAN_PYTHON_SUITE_PACKAGE_DEPENDS "python3-livermark, libopenblas0-serial, python3-meshio, python3-lz4")
# The libraries that the extension modules are linked with.
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PYTHON_SUITE_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
  "The program livermark with its bodies, load cases, references and page. With CHOLMOD, gmsh and CGAL under the GPL; see NOTICE.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME livermark)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
# BLAS of one thread, so the same numbers every time; and what its reports and converters import.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "libopenblas0-serial, python3, python3-livermark, python3-matplotlib, python3-jinja2, python3-meshio, python3-lz4")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "python3-openturns")
set(CPACK_STRIP_FILES ON)
# What Debian asks of each package: its licence and its changes.
file(WRITE ${livermark_BINARY_DIR}/installed/copyright "Livermark
Copyright 2026 The Livermark authors

The sources are under the Apache License, Version 2.0; on Debian systems the full text is in /usr/share/common-licenses/Apache-2.0.
A program that is linked with gmsh, CHOLMOD or CGAL is as a whole under the GPL, version 3 or later; on Debian systems the full text is in
/usr/share/common-licenses/GPL-3.
")
file(WRITE ${livermark_BINARY_DIR}/installed/changelog "livermark (${PROJECT_VERSION}) unstable; urgency=medium

  * CHANGELOG.md of the sources has what is new.

 -- ${CPACK_PACKAGE_CONTACT}  Sun, 01 Nov 2026 00:00:00 +0000
")
execute_process(COMMAND gzip -9 --no-name --force ${livermark_BINARY_DIR}/installed/changelog)
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} part)
  install(FILES ${livermark_BINARY_DIR}/installed/copyright ${livermark_BINARY_DIR}/installed/changelog.gz
    DESTINATION share/doc/${CPACK_DEBIAN_${part}_PACKAGE_NAME} COMPONENT ${component})
endforeach()
include(CPack)
