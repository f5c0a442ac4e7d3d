#pragma once

#include <functional>
#include <string>
#include <vector>

#include "fem_reference/hyperelastic/hyperelasticity.hpp"

namespace livermark::hyperelastic {

/// @throws std::invalid_argument if the fractions do not ascend to 1
void check(const LoadPath &path);

/// What a path says of the mesh, all but degrees of freedom and solver.
/// @param at_mesh_nodes  (N) of displacements of the elements
PathSolution path_solution(const FollowedPath &followed, const core::TetraMesh &mesh, const core::LoadCase &load_case,
                           const std::function<std::vector<core::Vector3>(const std::vector<double> &)> &at_mesh_nodes);

/// A path that cannot begin, because the load case leaves the body free to move.
FollowedPath free_to_move();

/// For the result file.
/// @param inverses  "factors by CHOLMOD" or the like
std::string description(const FollowedPath &path, const std::string &inverses);

} // namespace livermark::hyperelastic
