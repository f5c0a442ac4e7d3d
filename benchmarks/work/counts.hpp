#pragma once

#include <cstdint>

/// What kernels do that were compiled to count it: see counting/hwy/highway.h and memory_traffic.cpp.
namespace livermark::benchmarks {

struct Work {
    std::uint64_t operations = 0; ///< floating point operations
    std::uint64_t bytes = 0;      ///< that the cache of the model exchanged with the memory behind it
};

/// Counts from now on, with the cache as it is.
void begin_counting();

/// Stops, and says what there was. Lines that were written count as written back.
Work end_counting();

/// Adds some operations if something counts. Multiplication with addition is two, and so are all of Highway's that do
/// two at once; comparing, choosing, signs, and whole numbers are none.
void count_operations(int number);

} // namespace livermark::benchmarks
