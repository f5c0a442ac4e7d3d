#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "core/problem.hpp"

/// The same static problem for CalculiX (ccx, https://www.calculix.de), an independent finite element solver. Nothing
/// of fem_reference is used on the way.
namespace livermark::tests {

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
