#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

/// Loops that do one thing as fast as this machine can, with the widest vectors that it has (Highway).
namespace livermark::benchmarks {

/// Fetches positions, four floats each, from where the offsets say, and adds them up: the least that a kernel has to do
/// that needs the positions of scattered neighbours.
/// @param positions  shape (N, 4), aligned to 16 bytes
/// @param offsets    4 times node numbers, of a multiple of 8
/// @param sum        shape (4)
void fetch(const float *positions, std::span<const std::uint32_t> offsets, float *sum);

/// a = b + s c, the triad of McCalpin's STREAM.
/// @param a, b, c  shape (size), aligned to 64 bytes; size is a multiple of 64
void triad(float *a, const float *b, const float *c, float s, std::size_t size);

/// Sum of an array.
/// @param a  shape (size), aligned to 64 bytes; size is a multiple of 64
float add_up(const float *a, std::size_t size);

/// Chains of y <- y m + b that do not wait for each other, from y = x, x + 1, ... in every lane of a vector each.
/// @return the sum of the chains, of one lane
float multiply_add(float x, float m, float b, std::size_t length);

inline constexpr std::size_t num_chains = 12; ///< of multiply_add(): enough to hide that each step takes four cycles

/// How many floating point operations multiply_add() does for each unit of length.
std::size_t operations_of_multiply_add();

/// Name of the instruction set in use.
const char *instruction_set();

} // namespace livermark::benchmarks
