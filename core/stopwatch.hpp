#pragma once

#include <chrono>

namespace livermark::core {

using Clock = std::chrono::steady_clock;

/// Wall-clock time [s].
inline double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

} // namespace livermark::core
