#pragma once

#include <mutex>

#include "support/processes/forks.hpp"

namespace livermark::support {

/// Lets BLAS take its memory now if it has none yet in this process. OpenBLAS takes 128 MiB when it is called first,
/// and tries again for ever where it gets none.
/// @throws std::bad_alloc if there is not so much
void reserve_blas_memory();

/// Holds every other thread that calls BLAS back while it lives. The OpenBLAS for programs of one thread, which CHOLMOD
/// runs on, gives two threads the same buffer, and both find numbers that belong to neither.
inline std::unique_lock<std::mutex> only_in_blas() {
    struct Blas;
    return std::unique_lock(mutex_of_process<Blas>());
}

} // namespace livermark::support
