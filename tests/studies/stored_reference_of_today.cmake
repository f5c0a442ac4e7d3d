# Solves one of the stored references again, another one every day, and fails if the solution is not the stored one.
# usage: cmake -DLIVERMARK=<program> -DSOURCE_DIR=<top of the repository> -P stored_reference_of_today.cmake
cmake_minimum_required(VERSION 3.25)
file(GLOB load_cases ${SOURCE_DIR}/load_cases/large_*.toml)
file(GLOB bodies ${SOURCE_DIR}/meshes/liver_*.toml)
list(LENGTH load_cases num_load_cases)
list(LENGTH bodies num_bodies)
string(TIMESTAMP day "%s" UTC)
math(EXPR day "${day} / 86400")
math(EXPR load_case "${day} % ${num_load_cases}")
math(EXPR body "${day} / ${num_load_cases} % ${num_bodies}")
list(GET load_cases ${load_case} load_case)
list(GET bodies ${body} body)
cmake_path(GET load_case STEM load_case)
cmake_path(GET body STEM body)
execute_process(COMMAND ${LIVERMARK} reference --check --model fem_p2p1_neo_hookean --body ${body} --load-case ${load_case}
  RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "the reference of ${body} / ${load_case} is not the one in results/references; if that is meant, run "
    "`livermark reference` and commit the files")
endif()
