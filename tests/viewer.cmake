# Tests of the page of `livermark view`, which need Node.js, a browser and the page; all else is built and tested without them.
# What the page needs may come after this: a test whose page, tools or browser are not there says so and is skipped.
option(LIVERMARK_VIEWER_TESTS "Test the page of livermark view, where its tools are there" ON)
if(NOT LIVERMARK_VIEWER_TESTS)
  message(STATUS "The page of `livermark view` is not tested: LIVERMARK_VIEWER_TESTS is off")
  return()
endif()
find_program(NODE node)
if(NOT NODE)
  message(STATUS "The page of `livermark view` is not tested: no node (Debian package nodejs)")
  return()
endif()
set(parts page opening conditions patches node_factor loads view server live live_link live_rest live_picture)
# The springs of the live page, compiled for this machine from the lines that WebAssembly is made of. Machines of other
# kinds have fused multiplications in all of their vectors, and other last digits.
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64" AND NOT CMAKE_BUILD_TYPE STREQUAL "Debug")
  include(portable)
  add_executable(live_replay live_replay.cpp)
  livermark_portable_sources(live_replay ${PROJECT_SOURCE_DIR})
  target_compile_options(live_replay PRIVATE -O3 -march=x86-64-v2)
  target_link_libraries(live_replay PRIVATE Boost::headers Eigen3::Eigen livermark_build_options)
  list(APPEND parts springs)
endif()
set(not_there 77)
foreach(part IN LISTS parts)
  add_test(NAME Viewer.${part} COMMAND ${NODE} ${PROJECT_SOURCE_DIR}/viewer/tests/when_built.mjs ${part}.test.mjs ${not_there})
  set_tests_properties(Viewer.${part} PROPERTIES LABELS viewer TIMEOUT 1500 SKIP_RETURN_CODE ${not_there}
    ENVIRONMENT "LIVERMARK_BUILD=${CMAKE_BINARY_DIR};LIVERMARK_ROOT=${PROJECT_SOURCE_DIR};PYTHON=${vtk_python}")
endforeach()
