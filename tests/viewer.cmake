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
set(parts page opening conditions patches slices vessels node_factor loads view server live live/needle live/grasp live/cut live/load_case live/tumours live/link live/foundation live/rest live/picture live/random_actions trial experiment/markers)
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
# A thousand pokes and pulls, pictures of every frame, cuts that are compared with those at rest, and finite elements in contact on another
# body than that of live/load_case, take minutes.
set(nightly_parts live/rest live/picture live/random_actions live/cut live/tumours springs)
foreach(part IN LISTS parts)
  set(tier full)
  if(part IN_LIST nightly_parts)
    set(tier nightly)
  endif()
  string(REPLACE "/" "_" name ${part})
  add_test(NAME Viewer.${name} COMMAND ${NODE} ${PROJECT_SOURCE_DIR}/app/viewer/tests/when_built.mjs ${part}.test.mjs ${not_there})
  set_tests_properties(Viewer.${name} PROPERTIES LABELS ${tier} TIMEOUT 1500 SKIP_RETURN_CODE ${not_there}
    ENVIRONMENT "LIVERMARK_BUILD=${CMAKE_BINARY_DIR};LIVERMARK_ROOT=${PROJECT_SOURCE_DIR};PYTHON=${vtk_python}")
endforeach()
