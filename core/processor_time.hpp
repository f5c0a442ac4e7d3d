#pragma once

#include <ctime>

namespace livermark::core {

/// Processor time of this thread, which the work of others on the same cores does not count for [s].
inline double processor_seconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

} // namespace livermark::core
