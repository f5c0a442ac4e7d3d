#pragma once

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

/// How a program ended.
struct ChildOutcome {
    int status = -1;                ///< its exit status; -1 if it could not be started or was killed
    std::vector<std::string> lines; ///< of its output and its errors, without empty ones
};

/// Runs a program to its end, without a shell.
/// @param words  its path or name, and its arguments
ChildOutcome run_program(const std::vector<std::string> &words);

/// What a program has printed.
struct Printed {
    int status = -1; ///< as of ChildOutcome
    std::string output;
};

/// Runs a program to its end, without a shell. Its errors go where those of this process go.
/// @param words  its path or name, and its arguments
Printed run_printing(const std::vector<std::string> &words);

/// How a program ended that turned its input into its output.
struct FilterOutcome {
    int status = -1; ///< as of ChildOutcome
    std::string output;
    std::vector<std::string> lines; ///< of its errors, without empty ones
};

/// Runs a program to its end, without a shell and without a file.
/// @param words  its path or name, and its arguments
/// @param input  what it reads; it need not read all of it
FilterOutcome run_filter(const std::vector<std::string> &words, std::string_view input);

/// What a script of scripts/ made of a file.
struct Converted {
    std::string text;
    std::vector<std::string> remarks; ///< lines that it printed
};

/// Lets a script, in a process of its own that may fail without harm, make a text file of another one.
/// @param script  name in scripts/; called with the file and the text file to write
/// @param remedy  what to do if it cannot, for the message
/// @throws InputError with the file, the last line that the script printed, and the remedy
Converted convert_by_script(const std::string &script, const std::filesystem::path &file, const std::string &remedy);

} // namespace livermark::support
