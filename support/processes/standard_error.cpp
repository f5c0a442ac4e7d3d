#include "support/processes/standard_error.hpp"

#include <cerrno>
#include <csignal>
#include <ctime>
#include <unistd.h>

namespace livermark::support {

namespace {

/// Says that all was written. A pipe without a reader would end the process by a signal, which is taken back.
ssize_t write_what_can_be(void * /*cookie*/, const char *text, std::size_t size) {
    sigset_t pipe_signal, before;
    sigemptyset(&pipe_signal);
    sigaddset(&pipe_signal, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe_signal, &before);
    std::size_t place = 0;
    while (place < size) {
        const auto written = write(STDERR_FILENO, text + place, size - place);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            break;
        place += static_cast<std::size_t>(written);
    }
    if (place < size && errno == EPIPE) {
        const timespec at_once{0, 0};
        sigtimedwait(&pipe_signal, nullptr, &at_once);
    }
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    return static_cast<ssize_t>(size);
}

} // namespace

UnfailingStandardError::UnfailingStandardError() : before_(stderr) {
    if (std::FILE *stream = fopencookie(nullptr, "w", {nullptr, write_what_can_be, nullptr, nullptr})) {
        std::setvbuf(stream, nullptr, _IOLBF, 4096); // lines of two processes do not mix
        stderr = stream;
    }
}

UnfailingStandardError::~UnfailingStandardError() {
    if (stderr != before_) {
        std::fclose(stderr);
        stderr = before_;
    }
}

} // namespace livermark::support
