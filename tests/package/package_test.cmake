# Installs the components core and msm into an empty prefix, builds a program of somebody else against them, and runs it.
# usage: cmake -DBUILD=<build folder> -DSOURCE=<tests/package> -DWORK=<scratch folder> -P package_test.cmake
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGN}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix --component core)
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix --component msm)
run(${CMAKE_COMMAND} -S ${SOURCE}/outside -B ${WORK}/build -G Ninja -DCMAKE_PREFIX_PATH=${WORK}/prefix)
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/theirs)
message(STATUS "${output}")
# What the program is linked with is what the component promises: nothing of deal.II, gmsh or CHOLMOD.
run(ldd ${WORK}/build/theirs)
if(output MATCHES "deal|gmsh|cholmod|hdf5|mpi")
  message(FATAL_ERROR "the component msm brings more than Eigen, fmt and Highway:\n${output}")
endif()
# A component that is not there is refused by name.
file(WRITE ${WORK}/none/CMakeLists.txt "cmake_minimum_required(VERSION 3.25)
project(none LANGUAGES CXX)
find_package(Livermark REQUIRED COMPONENTS viewer)
")
execute_process(COMMAND ${CMAKE_COMMAND} -S ${WORK}/none -B ${WORK}/none/build -DCMAKE_PREFIX_PATH=${WORK}/prefix
  RESULT_VARIABLE status ERROR_VARIABLE output OUTPUT_QUIET)
if(status EQUAL 0 OR NOT output MATCHES "no component viewer")
  message(FATAL_ERROR "an unknown component is not refused by name:\n${output}")
endif()
file(REMOVE_RECURSE ${WORK})
