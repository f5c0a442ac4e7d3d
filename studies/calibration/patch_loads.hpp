#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/load_case.hpp"

namespace livermark::studies {

/// Load cases that each pull at a disc of the free surface: the facets whose centroids are within a radius of 15 to 30
/// mm, drawn at random, of that of a facet drawn at random, and whose normals are within 60 degrees of its normal. The
/// traction is 1 Pa in a random direction. The same seed gives the same loads on every platform.
/// @param constrained  the patch that does not move, and belongs to no disc
/// @param count  at least 1
/// @throws support::InputError if the mesh has no such patch or nothing else
std::vector<core::LoadCase> random_patch_loads(const core::TetraMesh &mesh, const std::string &constrained, int count,
                                               std::int64_t seed);

} // namespace livermark::studies
