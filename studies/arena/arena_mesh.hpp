#pragma once

#include "core/problem.hpp"

namespace livermark::studies {

/// A problem on a mesh of an arena.
/// @param mesh  1 as it is, 2 with the longest edge of each tetrahedron bisected, 3 with each tetrahedron cut into
/// eight
core::Problem on_arena_mesh(const core::Problem &problem, int mesh);

} // namespace livermark::studies
