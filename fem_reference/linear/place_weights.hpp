#pragma once

#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "core/mesh/interior_place.hpp"
#include "fem_reference/linear/elastic_system.hpp"

namespace livermark::fem_reference {

/// Means of the shape functions over places inside: row k times the displacements of the nodes is the mean over place
/// k, and its transpose times a force on the place what the nodes take of it.
/// @param mesh  that the system was assembled on
/// @return shape (K, n)
/// @throws std::invalid_argument if a place is outside the body
Eigen::SparseMatrix<double, Eigen::RowMajor> place_weights(std::span<const core::InteriorPlace> places,
                                                           const ElasticSystem &system, const core::TetraMesh &mesh);

/// One newton along an axis on a place.
/// @return shape (3 n) [N]
std::vector<double> load_of(const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights, Eigen::Index place, int axis);

} // namespace livermark::fem_reference
