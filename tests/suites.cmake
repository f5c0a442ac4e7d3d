# livermark_discover_suites(<target> <name> LABEL <label> TIMEOUT <seconds>)
# Each suite of a GoogleTest executable is a test of ctest, <name>.<suite>. As a process of its own, each of two thousand tests would take longer to
# link two hundred libraries than to run. `<target> --gtest_filter=Suite.Test` runs one.
# What is in an executable is known when it is built: this file, as a script, then writes the tests for ctest to read.
if(CMAKE_SCRIPT_MODE_FILE)
  execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "(^|\n)[^ \n]+\\.( |\n)" suites "${listed}")
  set(tests "")
  foreach(suite IN LISTS suites)
    string(REGEX REPLACE "[ \n]|\\.( |\n)$" "" suite "${suite}")
    string(APPEND tests "add_test([[${NAME}.${suite}]] [[${PROGRAM}]] [[--gtest_filter=${suite}.*]] --gtest_brief=1)\n"
      "set_tests_properties([[${NAME}.${suite}]] PROPERTIES LABELS ${LABEL} TIMEOUT ${TIMEOUT})\n")
  endforeach()
  file(WRITE ${LIST} "${tests}")
  return()
endif()

function(livermark_discover_suites target name)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "LABEL;TIMEOUT" "")
  set(list ${CMAKE_CURRENT_BINARY_DIR}/${target}_suites.cmake)
  add_custom_command(TARGET ${target} POST_BUILD VERBATIM BYPRODUCTS ${list}
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${target}> -DNAME=${name} -DLIST=${list} -DLABEL=${arg_LABEL} -DTIMEOUT=${arg_TIMEOUT}
      -P ${CMAKE_CURRENT_FUNCTION_LIST_FILE})
  set(include ${CMAKE_CURRENT_BINARY_DIR}/${target}_include.cmake)
  file(WRITE ${include} "if(EXISTS [[${list}]])\n  include([[${list}]])\nelse()\n  add_test(${target}_NOT_BUILT ${target}_NOT_BUILT)\nendif()\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${include})
endfunction()
