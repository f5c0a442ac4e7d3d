#pragma once

#include <array>
#include <cstddef>
#include <cstdio>
#include <gtest/gtest.h>
#include <string>
#include <sys/wait.h>
#include <vector>

namespace livermark::tests {

struct Outcome {
    int status;
    std::string output; ///< standard output and error
};

/// Runs a shell command.
inline Outcome run_command(const std::string &command) {
    FILE *pipe = popen((command + " 2>&1").c_str(), "r");
    if (!pipe)
        return {-1, "cannot be started"};
    std::string output;
    std::array<char, 4096> buffer{};
    while (const auto size = std::fread(buffer.data(), 1, buffer.size(), pipe))
        output.append(buffer.data(), size);
    const int status = pclose(pipe);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, output};
}

/// Runs livermark as a user would.
inline Outcome livermark(const std::string &arguments) {
    return run_command(LIVERMARK_BINARY " " + arguments);
}

/// Number of times that a part stands in a text.
inline std::size_t count(const std::string &text, const std::string &part) {
    std::size_t number = 0;
    for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++number;
    return number;
}

/// Expects an exit status, and parts of what was printed.
inline void expect_outcome(const Outcome &outcome, int status, const std::vector<std::string> &parts) {
    EXPECT_EQ(outcome.status, status) << outcome.output;
    for (const auto &part : parts)
        EXPECT_NE(outcome.output.find(part), std::string::npos) << "'" << part << "' is missing in: " << outcome.output;
}

} // namespace livermark::tests
