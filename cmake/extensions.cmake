# livermark_extensions(<target> <folder> TYPE <type> HEADER <header> [EXCLUDE <regex>])
# Collects the one-file extensions of a folder into a table. Every <stem>.cpp in the folder defines
#   <type> livermark::<parent>::<folder>::<stem>();
# and the generated function
#   std::span<const <type>> livermark::<parent>::all_<folder>();
# returns them all in alphabetical order, each with its name set to <stem>. (Static self-registration in a static
# library would silently register nothing.) Stems that match the regular expression are left out.
function(livermark_extensions target folder)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "TYPE;HEADER;EXCLUDE" "")
  cmake_path(GET CMAKE_CURRENT_SOURCE_DIR FILENAME parent)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp)
  list(SORT sources)
  set(declarations "")
  set(entries "")
  foreach(source IN LISTS sources)
    cmake_path(GET source STEM stem)
    if(arg_EXCLUDE AND stem MATCHES "${arg_EXCLUDE}")
      list(REMOVE_ITEM sources ${source})
      continue()
    endif()
    string(APPEND declarations "${arg_TYPE} ${stem}();\n")
    string(APPEND entries "        named(\"${stem}\", ${folder}::${stem}()),\n")
  endforeach()
  set(table ${CMAKE_CURRENT_BINARY_DIR}/${folder}_table.cpp)
  file(CONFIGURE OUTPUT ${table} @ONLY CONTENT [[
// Written by cmake/extensions.cmake from the files of @folder@/.
#include <array>
#include <string>

#include "@arg_HEADER@"

namespace livermark::@parent@ {

namespace @folder@ {
@declarations@}

namespace {

@arg_TYPE@ named(std::string name, @arg_TYPE@ entry) {
    entry.name = std::move(name);
    return entry;
}

} // namespace

std::span<const @arg_TYPE@> all_@folder@() {
    static const auto table = std::to_array<@arg_TYPE@>({
@entries@    });
    return table;
}

} // namespace livermark::@parent@
]])
  # Each stays by itself, so that a new one can begin as a copy of another.
  set_source_files_properties(${sources} ${table} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  target_sources(${target} PRIVATE ${sources} ${table})
endfunction()
