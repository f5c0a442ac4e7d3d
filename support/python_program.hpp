#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace livermark::support {

/// Runs a part of the Python package of this project as a program of its own: `python3 -m livermark.<part>`, with the
/// interpreter of the distribution, or where that lacks a library with the first one in PATH.
/// @param part       such as report
/// @param arguments  of the program
/// @param input      what it reads
/// @param purpose    what needs the libraries, for the message where one is missing
/// @param packages   Debian packages that have them
/// @return its output
/// @throws InputError with the sentence of the program if its exit status is 2; with the packages if no interpreter has
///   the libraries
/// @throws std::runtime_error with all that it said if it failed in another way
std::string run_python(const std::string &part, const std::vector<std::string> &arguments, std::string_view input,
                       const std::string &purpose, const std::string &packages);

} // namespace livermark::support
