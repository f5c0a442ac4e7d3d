# cmake -DSOURCE_DIR=<repository> -DOUTPUT=<file.cpp> -P git_commit.cmake
# Writes git_commit() for the tree as it is now. Runs at every build and touches the file only when its content changes.
# An untracked file counts as a modification: the globs of the build may have compiled it in.
find_program(GIT git)
set(commit "unknown")
if(GIT)
  # --show-prefix is empty only at the top of a repository: sources unpacked somewhere inside a foreign repository do
  # not take its commit for theirs.
  execute_process(COMMAND ${GIT} rev-parse HEAD --show-prefix WORKING_DIRECTORY ${SOURCE_DIR}
    OUTPUT_VARIABLE answer RESULT_VARIABLE failed ERROR_QUIET)
  if(NOT failed AND answer MATCHES "^([0-9a-f]+)\n\n?$")
    set(head ${CMAKE_MATCH_1})
    execute_process(COMMAND ${GIT} status --porcelain WORKING_DIRECTORY ${SOURCE_DIR}
      OUTPUT_VARIABLE changes RESULT_VARIABLE failed ERROR_QUIET)
    if(NOT failed)
      set(commit ${head})
      if(changes)
        string(APPEND commit "-dirty")
      endif()
    endif()
  endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT [[
// Written by results/git_commit.cmake.
#include "results/records/result.hpp"

namespace livermark::results {

const char *git_commit() { return "@commit@"; }

} // namespace livermark::results
]])
