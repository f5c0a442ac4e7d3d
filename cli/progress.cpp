#include "cli/progress.hpp"

#include <cstdio>
#include <fmt/format.h>
#include <memory>
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

} // namespace

studies::ProgressReport print_progress() {
    return [line = std::make_shared<Line>()](int step, int num_steps, const std::string &about) {
        line->write(fmt::format("[{}/{}] {}", step, num_steps, about));
    };
}

void print_notes(const std::vector<std::string> &notes) {
    for (const auto &note : notes)
        fmt::print(stderr, "livermark: {}\n", note);
}

} // namespace livermark::cli
