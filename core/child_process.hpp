#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace livermark::core {

/// A folder for files that nobody needs afterwards; it goes with the object.
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

} // namespace livermark::core
