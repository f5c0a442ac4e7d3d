#include "app/progress.hpp"

#include <cstdio>
#include <fmt/format.h>
#include <unistd.h>

namespace livermark::app {

namespace {

constexpr const char *erase_line = "\r\033[K";

} // namespace

Progress::Progress(int num_steps) : num_steps_(num_steps), is_terminal_(isatty(fileno(stderr)) != 0) {}

Progress::~Progress() {
    if (is_terminal_ && step_ > 0)
        fmt::print(stderr, "{}", erase_line);
}

void Progress::next(const std::string &what) {
    const auto line = fmt::format("[{}/{}] {}", ++step_, num_steps_, what);
    if (is_terminal_)
        fmt::print(stderr, "{}{}", erase_line, line);
    else
        fmt::print(stderr, "{}\n", line);
    std::fflush(stderr);
}

} // namespace livermark::app
