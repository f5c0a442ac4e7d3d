# livermark_folder(<name> SOURCES <file>... LINK <target>...)
# The library of one folder: target livermark_<name>, alias livermark::<name>. Headers are included by their path from
# the top of the repository; which folder may include which is checked by tests/unit/allowed_includes.cmake.
option(LIVERMARK_WARNINGS_AS_ERRORS "Stop at the first compiler warning" OFF)

add_library(livermark_build_options INTERFACE)
target_compile_options(livermark_build_options INTERFACE -Wall -Wextra -Wpedantic
  $<$<BOOL:${LIVERMARK_WARNINGS_AS_ERRORS}>:-Werror>)
# The default linker takes ten times as long over the two hundred libraries behind deal.II.
find_program(GOLD_LINKER ld.gold)
if(GOLD_LINKER)
  target_link_options(livermark_build_options INTERFACE -fuse-ld=gold)
endif()

function(livermark_folder name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LINK")
  add_library(livermark_${name} STATIC ${arg_SOURCES})
  add_library(livermark::${name} ALIAS livermark_${name})
  target_include_directories(livermark_${name} PUBLIC ${CMAKE_SOURCE_DIR})
  target_link_libraries(livermark_${name} PUBLIC ${arg_LINK} PRIVATE livermark_build_options)
endfunction()
