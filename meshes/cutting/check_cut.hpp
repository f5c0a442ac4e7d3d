#pragma once

#include "meshes/cutting/cut.hpp"

namespace livermark::meshes {

/// Whether the tool of a cut is one: its numbers are finite, a margin and a thickness are not negative, a normal is not
/// zero, a blade has an area, and the mesh has the region.
/// @throws support::InputError  if it is none
/// @throws CutNotOnBody         if the mesh has no such region
void check_cut(const Cut &cut, const core::TetraMesh &mesh);

} // namespace livermark::meshes
