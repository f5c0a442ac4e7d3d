#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

namespace livermark::tests {

/// Bit by bit: NaN is like itself, and the zeros are not alike.
template <class T> bool same_bits(const std::vector<T> &a, const std::vector<T> &b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
inline bool same_bits(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

} // namespace livermark::tests
