#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/tetra_mesh.hpp"
#include "report/png.hpp"

namespace livermark::report {

/// The patches of a body in colours.
struct PatchPicture {
    Picture picture;                                         ///< the body from four sides
    std::vector<std::pair<std::string, std::string>> legend; ///< names of the patches, and their colours as #rrggbb
};

/// Draws the boundary of a body from the front, from behind, from above and from below, as a patient in LPS lies,
/// beside each other, each patch in a colour of its own.
/// @param width  of each of the four [pixel]
PatchPicture draw_patches(const core::TetraMesh &mesh, int width);

} // namespace livermark::report
