#pragma once

#include <cstddef>
#include <cstdint>
#include <hwy/aligned_allocator.h>
#include <span>
#include <string>
#include <vector>

#include "benchmarks/kernels/node_order.hpp"

namespace livermark::benchmarks {

/// Floats at an address that every vector can be loaded from.
using AlignedFloats = hwy::AlignedFreeUniquePtr<float[]>;

/// Memory that has been written to, so that none of it is left for the operating system to find.
AlignedFloats aligned_zeros(std::size_t size);

/// What fetch() is asked to do for a body: positions that are small whole numbers, so that their sums are exact.
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

/// What the operating system says that there is. A cache is looked at with half its size, memory with four times the
/// last cache but at most 1 GiB: where a cache is larger than that, as on some virtual machines, memory is left out.
std::vector<MemoryLevel> memory_levels();

/// Bytes per second that add_up() reads from an array of so many bytes, measured when it is first asked for.
double read_bandwidth(std::size_t bytes);

/// Floating point operations per second of multiply_add(), measured when first asked for.
double arithmetic_throughput();

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

/// What a step has to stream, per spring [byte]: at both ends a node number, the stiffness, and its product with the
/// rest length, all of 4 bytes; and per node a position read and another written, a velocity read and written, all of
/// 16 bytes, and a mass.
double streamed_bytes_per_spring(const Neighbours &neighbours);

/// What a spring takes at both ends: 3 to subtract positions, 5 for the squared length, 6 for its reciprocal root by an
/// estimate and a step of Newton's method, 2 for the force per length, 6 to add the force.
inline constexpr double operations_per_spring = 2.0 * 22.0;

} // namespace livermark::benchmarks
