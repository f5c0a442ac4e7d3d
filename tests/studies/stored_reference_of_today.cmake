# Solves one of the references that are stored again, another one every day, and fails if it is not what is stored.
# usage: cmake -DLIVERMARK=<program> -DSOURCE_DIR=<top of the repository> -P stored_reference_of_today.cmake
cmake_minimum_required(VERSION 3.25)
file(GLOB stored ${SOURCE_DIR}/results/references/*/*.fem_p2p1_neo_hookean.*.h5)
list(LENGTH stored num_stored)
if(num_stored EQUAL 0)
  message(FATAL_ERROR "no reference is stored in results/references; run `livermark reference`")
endif()
string(TIMESTAMP day "%s" UTC)
math(EXPR number "${day} / 86400 % ${num_stored}")
list(GET stored ${number} file)
cmake_path(GET file PARENT_PATH body)
cmake_path(GET body FILENAME body)
cmake_path(GET file STEM load_case)
execute_process(COMMAND ${LIVERMARK} reference --check --model fem_p2p1_neo_hookean --body ${body} --load-case ${load_case}
  RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "the reference of ${body} / ${load_case} is not the one in results/references; if that is meant, run "
    "`livermark reference` and commit the files")
endif()
