#pragma once

#include <array>
#include <span>
#include <vector>

#include "fem_reference/linear/elastic_system.hpp"

namespace livermark::fem_reference {

/// Between which corners the nodes of a quadratic tetrahedron behind its corners lie.
inline constexpr std::array<std::array<int, 2>, 6> edges_of_quadratic{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

/// The functions of a coarse space as functions of a finer one that contains it: the value at fine node i is the sum
/// of weight times the value at a coarse node, the same for each component.
struct Prolongation {
    std::vector<int> row_start;   ///< (n_fine + 1) index into coarse_node and weight
    std::vector<int> coarse_node; ///< (nonzeros)
    std::vector<double> weight;   ///< (nonzeros)
    std::vector<int> fine_node;   ///< (n_coarse) the fine node at the same place as each coarse node

    /// fine_c += P coarse_c
    /// @param coarse  shape (3 n_coarse, lanes), see multivector.hpp
    /// @param fine    shape (3 n_fine, lanes)
    void add_prolonged(std::span<const double> coarse, std::span<double> fine) const;
    void add_prolonged(std::span<const float> coarse, std::span<float> fine) const;

    /// coarse_c = P^T fine_c
    void restrict_to(std::span<const double> fine, std::span<double> coarse) const;
    void restrict_to(std::span<const float> fine, std::span<float> coarse) const;
};

/// The prolongation from a body's system to one of degree 2: from degree 2 to that of core::refine(body), or from
/// degree 1 to that of the same body.
/// @throws std::invalid_argument if the fine system is neither
Prolongation prolongation(const ElasticSystem &coarse, const ElasticSystem &fine);

} // namespace livermark::fem_reference
