#pragma once

extern "C" void omp_set_max_active_levels(int levels); // the OpenMP runtime comes with CHOLMOD

namespace livermark::support {

/// Keeps what CHOLMOD would spread over OpenMP threads in the thread that calls this, and then CHOLMOD. Sums do not
/// depend on the machine then, nothing waits in a loop on a core that another process needs, and the process may fork.
inline void keep_openmp_in_this_thread() {
    omp_set_max_active_levels(0);
}

} // namespace livermark::support
