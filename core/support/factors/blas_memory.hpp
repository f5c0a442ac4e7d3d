#pragma once

#include <mutex>

#include "core/support/processes/own_process.hpp"

extern "C" void omp_set_max_active_levels(int levels); // the OpenMP runtime comes with CHOLMOD

namespace livermark::support {

/// Keeps what CHOLMOD would spread over OpenMP threads in the thread that calls this, and then CHOLMOD. Sums do not
/// depend on the machine then, nothing waits in a loop on a core that another process needs, and the process may fork.
inline void keep_openmp_in_this_thread() {
    omp_set_max_active_levels(0);
}

/// Holds every other ordering of a sparse matrix back while it lives. METIS, which CHOLMOD orders with, seeds the
/// random numbers of the C library and draws from them: two orderings at a time draw from one sequence, and find others
/// than each alone. All numbers behind such a factor differ in their last digits then.
inline std::unique_lock<std::mutex> only_ordering() {
    struct Orderings;
    return std::unique_lock(mutex_of_process<Orderings>());
}

/// Holds every other thread that calls BLAS back while it lives. The OpenBLAS for programs of one thread, which CHOLMOD
/// runs on, gives two threads the same buffer, and both find numbers that belong to neither.
inline std::unique_lock<std::mutex> only_in_blas() {
    struct Blas;
    return std::unique_lock(mutex_of_process<Blas>());
}

} // namespace livermark::support
