#include "core/support/factors/blas_memory.hpp"

#include <atomic>
#include <cstddef>
#include <new>
#include <sys/mman.h>

/// A function of BLAS, as Eigen declares it: C = alpha A A^T + beta C, with A (n, k) column by column.
extern "C" int dsyrk_(const char *triangle, const char *transposed, const int *n, const int *k, const double *alpha,
                      const double *a, const int *stride_of_a, const double *beta, double *c, const int *stride_of_c);

namespace livermark::support {

void reserve_blas_memory() {
    static std::atomic<bool> is_there = false;
    if (is_there)
        return;
    constexpr std::size_t enough = std::size_t{160} << 20; // its buffer, with room around it
    void *probe = mmap(nullptr, enough, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (probe == MAP_FAILED) // NOLINT(performance-no-int-to-ptr): as POSIX has it
        throw std::bad_alloc();
    munmap(probe, enough);
    // The routine takes the buffer however small the matrix is, and BLAS keeps it for the calls to come.
    const auto lock = only_in_blas();
    const int size = 1;
    const double one = 1.0;
    double product = 0.0;
    dsyrk_("L", "N", &size, &size, &one, &one, &size, &one, &product, &size);
    is_there = true;
}

} // namespace livermark::support
