# livermark_folder(<name> SOURCES <file>... LINK <target>... [COMPONENT <component>])
# The library of one folder: target livermark_<name>, alias livermark::<name>. Headers are included by their path from
# the top of the repository; which folder may include which is checked by tests/house/allowed_includes.cmake. With a
# component it is installed, see cmake/install.cmake.
option(LIVERMARK_WARNINGS_AS_ERRORS "Stop at the first compiler warning" OFF)

add_library(livermark_build_options INTERFACE)
# Without any optimisation Eigen, CGAL and vector instructions make minutes of a mesh or a step in a Debug build.
target_compile_options(livermark_build_options INTERFACE -Wall -Wextra -Wpedantic $<$<CONFIG:Debug>:-O1>
  $<$<BOOL:${LIVERMARK_WARNINGS_AS_ERRORS}>:-Werror>)
# The default linker takes ten times as long over the two hundred libraries behind deal.II.
find_program(GOLD_LINKER ld.gold)
if(GOLD_LINKER)
  target_link_options(livermark_build_options INTERFACE -fuse-ld=gold)
endif()

function(livermark_folder name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "COMPONENT" "SOURCES;LINK")
  add_library(livermark_${name} STATIC ${arg_SOURCES})
  add_library(livermark::${name} ALIAS livermark_${name})
  target_include_directories(livermark_${name} PUBLIC $<BUILD_INTERFACE:${livermark_SOURCE_DIR}>
    $<BUILD_INTERFACE:${livermark_BINARY_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  # The Python package is made of most of them, and what is compiled without it need not be compiled again for it.
  set_target_properties(livermark_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_compile_features(livermark_${name} PUBLIC cxx_std_20)
  target_link_libraries(livermark_${name} PUBLIC ${arg_LINK} PRIVATE $<BUILD_INTERFACE:livermark_build_options>)
  if(arg_COMPONENT)
    set_target_properties(livermark_${name} PROPERTIES EXPORT_NAME ${name})
    install(TARGETS livermark_${name} EXPORT livermark_${arg_COMPONENT}
      ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${arg_COMPONENT})
  endif()
endfunction()

# livermark_link_external(<target> cholmod|blas|dealii...)
# Links privately what cmake/finite_elements.cmake defines as livermark_<name>. An installed package includes that file
# itself, and calls them livermark::external_<name>.
function(livermark_link_external target)
  foreach(library IN LISTS ARGN)
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:livermark_${library}>
      $<INSTALL_INTERFACE:livermark::external_${library}>)
  endforeach()
endfunction()
