#pragma once

#include <chrono>
#include <ctime>

namespace livermark::core {

using Clock = std::chrono::steady_clock;

/// Wall-clock time [s].
inline double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Processor time of this thread, which the work of others on the same cores does not count for [s].
inline double processor_seconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

} // namespace livermark::core
