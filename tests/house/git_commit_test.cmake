# cmake -DSCRIPT=<results/git_commit.cmake> -DWORK=<directory to make> -P git_commit_test.cmake
# The commit in a program is that of the tree it was built from.
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK}/repository/inside ${WORK}/plain)
set(output ${WORK}/git_commit.cpp)
# Whatever repository the build directory is in must not answer for the directories made here.
set(ENV{GIT_CEILING_DIRECTORIES} ${WORK})

function(git)
  execute_process(COMMAND git -c user.name=test -c user.email=test@example.org ${ARGV}
    WORKING_DIRECTORY ${WORK}/repository OUTPUT_VARIABLE answer OUTPUT_STRIP_TRAILING_WHITESPACE
    COMMAND_ERROR_IS_FATAL ANY)
  set(answer ${answer} PARENT_SCOPE)
endfunction()

function(expect commit directory)
  execute_process(COMMAND ${CMAKE_COMMAND} -DSOURCE_DIR=${directory} -DOUTPUT=${output} -P ${SCRIPT}
    COMMAND_ERROR_IS_FATAL ANY)
  file(READ ${output} text)
  string(FIND "${text}" "return \"${commit}\";" found)
  if(found EQUAL -1)
    message(SEND_ERROR "expected ${commit} for ${directory} in\n${text}")
  endif()
endfunction()

git(init --quiet)
file(WRITE ${WORK}/repository/file.txt "first")
git(add file.txt)
git(commit --quiet --message first)
git(rev-parse HEAD)
set(first ${answer})
expect(${first} ${WORK}/repository)

file(TIMESTAMP ${output} before "%s" UTC)
execute_process(COMMAND ${CMAKE_COMMAND} -E sleep 1.1)
expect(${first} ${WORK}/repository)
file(TIMESTAMP ${output} after "%s" UTC)
if(NOT before STREQUAL after)
  message(SEND_ERROR "the file is written again though nothing changed, so that every build would compile it")
endif()

file(WRITE ${WORK}/repository/file.txt "second")
expect(${first}-dirty ${WORK}/repository)
git(commit --quiet --all --message second)
git(rev-parse HEAD)
expect(${answer} ${WORK}/repository)

file(WRITE ${WORK}/repository/untracked.txt "")
expect(${answer}-dirty ${WORK}/repository)
expect(unknown ${WORK}/repository/inside)
expect(unknown ${WORK}/plain)
