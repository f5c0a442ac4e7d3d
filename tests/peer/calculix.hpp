#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "core/problem.hpp"

/// The same static problem for CalculiX (ccx, https://www.calculix.de), an independent finite element solver. Nothing
/// of fem_reference is used on the way.
namespace livermark::tests {

/// Writes a problem as CalculiX input: C3D4 or C3D10 with straight edges, a *MATERIAL and an ELSET for each region,
/// *BOUNDARY for what is prescribed, *CLOAD with the consistent nodal forces of the tractions (a facet's force goes in
/// equal parts to its corners, or to its edge midpoints), *DLOAD GRAV for the acceleration. Node i of the mesh is node
/// i + 1, tetrahedron t is element t + 1, the middle of edge e of core::edge_table is node N + e + 1; lengths are
/// metres, forces newtons. Every displacement goes to the .dat file.
/// @param degree  1 or 2
void write_inp(std::ostream &out, const core::Problem &problem, int degree);

/// Reads the displacements of the first nodes from a .dat file; seven digits is what CalculiX writes.
/// @return shape (num_nodes) [m]
/// @throws std::runtime_error if a node is missing
std::vector<core::Vector3> read_dat(std::istream &in, int num_nodes);

/// The ccx on the PATH, or an empty path.
std::filesystem::path find_ccx();

/// Lets ccx solve a problem with one thread.
/// @param folder  is made; keeps input, output and log
/// @return displacement of the mesh nodes, shape (N) [m]
/// @throws std::runtime_error if ccx fails
std::vector<core::Vector3> solve_with_calculix(const std::filesystem::path &ccx, const core::Problem &problem,
                                               int degree, const std::filesystem::path &folder);

} // namespace livermark::tests
