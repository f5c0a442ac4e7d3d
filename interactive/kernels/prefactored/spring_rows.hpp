#pragma once

#include <cstdint>
#include <vector>

#include "interactive/elements/spring_body.hpp"
#include "interactive/kernels/node_rows.hpp"

namespace livermark::interactive::kernels {

/// Numbers of a spring at one of its nodes: from there to the other one at rest, length at rest, stiffness.
inline constexpr std::size_t numbers_of_spring = 5;

/// Springs at nodes for vector units, in single precision. 16 nodes stand side by side, and each spring stands at both
/// of its nodes: so nodes sum their own forces, and nothing is scattered. They are filled up with springs of no
/// stiffness.
struct SpringRows : NodeRows {
    std::vector<std::size_t> item_start; ///< (rows / 16 + 1) in units of 16: the k-th spring of nodes side by side
    Aligned<std::int32_t> other;         ///< four times the row of the other node
    Aligned<float> numbers;              ///< numbers_of_spring vectors of 16 for each
    Aligned<std::int32_t> self;          ///< (rows) four times the row
    Aligned<float> force;                ///< rows of four [N]

    std::size_t bytes() const { return NodeRows::bytes() + bytes_of(item_start, other, numbers, self, force); }
};

SpringRows spring_rows(const Scene &scene, const Springs &springs);

} // namespace livermark::interactive::kernels
