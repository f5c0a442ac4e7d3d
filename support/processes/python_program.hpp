#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace livermark::support {

/// The words that start Python with a program behind them. Nothing of the working directory is run, which may be a
/// folder of results that somebody was sent: no module there takes the place of one of Python's, neither by itself (-P,
/// Python 3.11) nor by an empty or relative place in PYTHONPATH. PYTHONHOME of another interpreter is left out.
/// @param interpreter  path or name
std::vector<std::string> start_of_python(const std::string &interpreter);

/// What to do where a program in Python could not import a module that is there, or could not start, and PYTHONPATH
/// names places to look for modules, which may be those of another Python.
/// @param lines  that it wrote to standard error
/// @return empty for another end, or if there is no such variable
std::string remedy_for_modules(const std::vector<std::string> &lines);

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
