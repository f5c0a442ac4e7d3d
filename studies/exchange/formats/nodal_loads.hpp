#pragma once

#include <vector>

#include "core/problem.hpp"

namespace livermark::studies {

/// Nodes of elements and facets in the order of CalculiX and Abaqus, counted from 0: those of the mesh, then the
/// middles of the edges of core::edge_table.
struct Discretisation {
    std::vector<core::Vector3> points;      ///< (n) [m]
    std::vector<std::vector<int>> elements; ///< (M) 4 or 10 nodes
    std::vector<std::vector<int>> facets;   ///< (T) 3 corners, then 3 midpoints
};

/// @param degree  1 or 2
Discretisation discretise(const core::TetraMesh &mesh, int degree);

/// The value that each component of each node is constrained at, NaN where it is free. Where constraints meet, the one
/// of lowest index wins, as it does for every model.
/// @return shape (n) [m]
std::vector<core::Vector3> prescribed_displacement(const core::LoadCase &load_case, const Discretisation &fem);

/// A constant traction on a straight triangle acts in thirds on the corners of linear elements; of quadratic ones the
/// corners' shape functions have no mean over a face, and the midpoints get a third each. Where a place presses, these
/// are the forces of one newton of it.
/// @return shape (n) [N]
std::vector<core::Vector3> traction_forces(const core::TetraMesh &mesh, const core::LoadCase &load_case,
                                           const Discretisation &fem);

} // namespace livermark::studies
