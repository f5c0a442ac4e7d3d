#include "app/cli/progress.hpp"

#include <chrono>
#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <unistd.h>

namespace livermark::cli {

namespace {

constexpr const char *erase_line = "\r\033[K";

/// The line of a terminal.
class Line {
  public:
    Line() = default;
    ~Line() {
        if (is_terminal_ && is_written_)
            fmt::print(stderr, "{}", erase_line);
    }
    Line(const Line &) = delete;
    Line &operator=(const Line &) = delete;

    void write(const std::string &text) {
        is_written_ = true;
        if (is_terminal_)
            fmt::print(stderr, "{}{}", erase_line, text);
        else
            fmt::print(stderr, "{}\n", text);
        std::fflush(stderr);
    }

  private:
    bool is_terminal_ = isatty(fileno(stderr)) != 0;
    bool is_written_ = false;
};

/// "1:05", or "1:02:05" from an hour on.
std::string clock_text(double seconds) {
    const auto whole = static_cast<long>(seconds);
    return whole < 3600 ? fmt::format("{}:{:02}", whole / 60, whole % 60)
                        : fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

/// What has passed since the first step, and what the rest takes if its steps are as long as those before.
std::string time_text(double passed, int step, int num_steps) {
    constexpr double soonest = 5.0; // [s]
    if (passed < soonest)
        return {};
    const double rest = passed / (step - 1) * (num_steps - step + 1);
    return fmt::format(" ({}, about {} left)", clock_text(passed), clock_text(rest));
}

} // namespace

studies::ProgressReport print_progress() {
    using Clock = std::chrono::steady_clock;
    return [line = std::make_shared<Line>(), start = std::make_shared<std::optional<Clock::time_point>>()](
               int step, int num_steps, const std::string &about) {
        const auto now = Clock::now();
        if (!*start)
            *start = now;
        const double passed = std::chrono::duration<double>(now - **start).count();
        line->write(
            fmt::format("[{}/{}] {}{}", step, num_steps, about, step > 1 ? time_text(passed, step, num_steps) : ""));
    };
}

void print_notes(const std::vector<std::string> &notes) {
    for (const auto &note : notes)
        fmt::print(stderr, "livermark: {}\n", note);
}

} // namespace livermark::cli
