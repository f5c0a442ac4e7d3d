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

/// The prolongation from a body's system to one of degree 2: from degree 2 to that of a body whose tetrahedra are parts
/// of the coarse ones, or from degree 1 to that of the same body.
/// @param parent  (M_fine) the coarse tetrahedron that each is a part of, whose edges were cut in two at most once
///                (core::bisect()); empty for all of the same body in order, or for core::refine(body)
/// @throws std::invalid_argument if the fine system is not of such parts
Prolongation prolongation(const ElasticSystem &coarse, const ElasticSystem &fine, std::span<const int> parent = {});

/// The parents of prolongation() where they are not given.
/// @throws std::invalid_argument if the fine system has neither as many tetrahedra nor eight times as many
std::vector<int> parents_by_number(const ElasticSystem &coarse, const ElasticSystem &fine);

} // namespace livermark::fem_reference
