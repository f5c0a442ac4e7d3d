#pragma once

#include <string>
#include <vector>

#include "core/problem.hpp"
#include "meshes/io/body_reader.hpp"
#include "studies/run/problems.hpp"

/// Load cases with a tool, and the meshes of an arena.
namespace livermark::studies {

/// Names of load_cases/moving/.
std::vector<std::string> moving_load_cases();

/// Whether a load case is one of these, or the path of one with a [tool].
bool moves_tool(const std::string &load_case);

/// Bodies under a load case of moving_load_cases(), or of a path.
/// @throws support::InputError
ProblemSet read_arena_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                               const meshes::MaterialOverride &material = {});

/// A problem on a mesh of an arena.
/// @param mesh  1 as it is, 2 with the longest edge of each tetrahedron bisected, 3 with each tetrahedron cut into
///              eight
core::Problem on_arena_mesh(const core::Problem &problem, int mesh);

/// Interactive methods constrain whole nodes.
/// @throws support::InputError if a place of the load case leaves a component of its displacement free
void refuse_single_components(const core::LoadCase &load_case);

} // namespace livermark::studies
