#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace livermark::support {

/// A folder for files that nobody needs afterwards; it goes with the object, and where SIGINT, SIGTERM or SIGHUP ends
/// the process.
class ScratchFolder {
  public:
    /// @throws InputError if there is no room for temporary files
    ScratchFolder();
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder &) = delete;
    ScratchFolder &operator=(const ScratchFolder &) = delete;

    std::filesystem::path path;
};

/// End of a program.
struct ChildOutcome {
    int status = -1;                ///< its exit status; -1 if it could not be started or was killed
    std::vector<std::string> lines; ///< of its output and its errors, without empty ones
};

/// Runs a program to its end, without a shell.
/// @param words  its path or name, and its arguments
ChildOutcome run_program(const std::vector<std::string> &words);

/// Output of a program.
struct Printed {
    int status = -1; ///< as of ChildOutcome
    std::string output;
};

/// Runs a program to its end, without a shell. Its errors go where those of this process go.
/// @param words  its path or name, and its arguments
Printed run_printing(const std::vector<std::string> &words);

/// End of a program that turned its input into its output.
struct FilterOutcome {
    int status = -1; ///< as of ChildOutcome
    std::string output;
    std::vector<std::string> lines; ///< of its errors, without empty ones
};

/// Runs a program to its end, without a shell and without a file.
/// @param words  its path or name, and its arguments
/// @param input  what it reads; it need not read all of it
FilterOutcome run_filter(const std::vector<std::string> &words, std::string_view input);

/// Output of a script of scripts/ for a file.
struct Converted {
    std::string text;
    std::vector<std::string> remarks; ///< lines that it printed
};

/// Lets a script, in a process of its own that may fail without harm, make a text file of another one.
/// @param script  name in scripts/; called with the file and the text file to write
/// @param remedy  what to do if it cannot, for the message
/// @throws InputError with the file, the last line that the script printed, and the remedy
Converted convert_by_script(const std::string &script, const std::filesystem::path &file, const std::string &remedy);

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

/// Ends this program, and lets a part of the Python package, run_python(), take its place: its terminal, its output and
/// its exit status.
/// @throws as run_python()
[[noreturn]] void continue_as_python(const std::string &part, const std::vector<std::string> &arguments,
                                     const std::string &purpose, const std::string &packages);

/// While it lives, writing to standard error always succeeds: what nobody can read, because the terminal has gone, the
/// disk is full or the stream is closed, is dropped, and the work goes on.
class UnfailingStandardError {
  public:
    UnfailingStandardError();
    ~UnfailingStandardError();
    UnfailingStandardError(const UnfailingStandardError &) = delete;
    UnfailingStandardError &operator=(const UnfailingStandardError &) = delete;

  private:
    std::FILE *before_;
};

} // namespace livermark::support
