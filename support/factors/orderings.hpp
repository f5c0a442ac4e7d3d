#pragma once

#include <mutex>

#include "support/processes/forks.hpp"

namespace livermark::support {

/// Holds every other ordering of a sparse matrix back while it lives. METIS, which CHOLMOD orders with, seeds the
/// random numbers of the C library and draws from them: two orderings at a time draw from one sequence, and find others
/// than each alone. All numbers behind such a factor differ in their last digits then.
inline std::unique_lock<std::mutex> only_ordering() {
    struct Orderings;
    return std::unique_lock(mutex_of_process<Orderings>());
}

} // namespace livermark::support
