#pragma once

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace livermark::tests {

/// Settings of a child process.
struct ChildOptions {
    std::filesystem::path folder{};               ///< where it works
    std::filesystem::path output{};               ///< where its standard output goes; kept if empty
    std::optional<std::uint64_t> largest_file{};  ///< [byte]; what writes more meets a disk that is full
    std::optional<std::uint64_t> address_space{}; ///< [byte]; what takes more meets a machine without memory
    bool without_rights = false;                  ///< as the user nobody, if this is root, who may read everything
    std::function<bool()> killed_when{};          ///< asked every millisecond whether to kill it
    int kill_signal = SIGKILL;                    ///< with what
};

/// End of a child process.
struct ChildEnd {
    int status = -1;          ///< exit status, -1 if a signal ended it
    int signal = 0;           ///< that ended it, 0 if none
    bool was_started = false; ///< false if nobody may not start it
    std::string output{};
    std::string errors{};
};

/// Runs a program to its end, or until it is killed.
/// @param words  path of the program, and its arguments
ChildEnd run_child(const std::vector<std::string> &words, const ChildOptions &options);

} // namespace livermark::tests
