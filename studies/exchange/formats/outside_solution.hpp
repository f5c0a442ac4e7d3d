#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::studies {

/// The solution of a static problem by a model outside of this suite: where its nodes are, and how far they move.
struct OutsideSolution {
    std::vector<core::Vector3> points;       ///< (K) at rest [m]
    std::vector<core::Vector3> displacement; ///< (K) [m]
};

/// Reads a solution: CSV with the header x,y,z,ux,uy,uz and a line for each node [m]; or, after
/// scripts/convert_solution, HDF5 with the datasets points and displacement, or VTU and what else meshio reads, with
/// the point data displacement.
/// @throws support::InputError with file, line and remedy
OutsideSolution read_outside_solution(const std::filesystem::path &file);

/// The same from the text of a CSV. The name is for messages.
OutsideSolution parse_outside_solution(const std::string &text, const std::string &file);

/// The displacement of each node of a mesh, whatever the order of the solution. Points that are no nodes, such as edge
/// midpoints, are passed over.
/// @param file  named in messages
/// @return shape (N) [m]
/// @throws support::InputError if a node is not among the points, or with two displacements: the solution belongs to
///   another problem, or is in another unit, which is named if it is plain
std::vector<core::Vector3> displacement_at_nodes(const OutsideSolution &solution, const core::TetraMesh &mesh,
                                                 const std::string &file);

} // namespace livermark::studies
