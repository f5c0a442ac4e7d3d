#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <hwy/aligned_allocator.h>
#include <span>
#include <string>
#include <vector>

/// Limits of one core of this machine: loops that do one thing as fast as it can, with the widest vectors that it has
/// (Highway), and what they say of a step of springs.
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

/// Floating point operations of multiply_add() for each unit of length.
std::size_t operations_of_multiply_add();

/// Name of the instruction set in use.
const char *instruction_set();

/// The neighbours of each node, one node after the other, with the nodes in reverse Cuthill-McKee order: what a kernel
/// fetches that computes all springs of a node together. Every spring stands at both of its ends.
struct Neighbours {
    std::vector<int> start;     ///< (N + 1) index into neighbour
    std::vector<int> neighbour; ///< (2 S) node numbers in that order

    int num_nodes() const { return static_cast<int>(start.size()) - 1; }
    int num_springs() const { return static_cast<int>(neighbour.size()) / 2; }
};

Neighbours neighbours(std::span<const std::array<int, 2>> edges, int num_nodes);

/// Floats at an address that every vector can be loaded from.
using AlignedFloats = hwy::AlignedFreeUniquePtr<float[]>;

/// Memory that has been written to, so that none of it is left for the operating system to find.
AlignedFloats aligned_zeros(std::size_t size);

/// Input of fetch() for a body: positions that are small whole numbers, so that their sums are exact.
struct FetchCase {
    explicit FetchCase(const Neighbours &neighbours);

    AlignedFloats positions;            ///< (N, 4)
    std::vector<std::uint32_t> offsets; ///< (2 S), and the first node again up to a multiple of 8
    double sum = 0.0;                   ///< what comes out, of the first component
};

/// A level of the memory hierarchy, and how much data shows its speed.
struct MemoryLevel {
    std::string name; ///< L1, L2, L3, memory
    std::size_t bytes;
};

/// The levels that the operating system names. A cache is looked at with half its size, memory with four times the
/// last cache but at most 1 GiB: where a cache is larger than that, as on some virtual machines, memory is left out.
std::vector<MemoryLevel> memory_levels();

/// The least time that one evaluation of all spring forces can take on one core of this machine, per spring [s], in a
/// kernel with single precision that has every spring at both of its ends. These three go on at the same time.
struct SpringLimit {
    double fetch = 0.0;      ///< fetching two positions, in the order of the nodes
    double memory = 0.0;     ///< reading what each step reads and writes once, as if writing took no longer
    double arithmetic = 0.0; ///< the operations

    double longest() const;
};

/// Measured anew at each call, in about 0.2 s.
SpringLimit spring_limit(const Neighbours &neighbours);

/// Bytes that a step has to stream, per spring: at both ends a node number, the stiffness, and its product with the
/// rest length, all of 4 bytes; and per node a position read and another written, a velocity read and written, all of
/// 16 bytes, and a mass.
double streamed_bytes_per_spring(const Neighbours &neighbours);

/// Operations of a spring at both ends: 3 to subtract positions, 5 for the squared length, 6 for its reciprocal root by
/// an estimate and a step of Newton's method, 2 for the force per length, 6 to add the force.
inline constexpr double operations_per_spring = 2.0 * 22.0;

} // namespace livermark::benchmarks
