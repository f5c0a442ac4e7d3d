#pragma once

#include <array>
#include <string>
#include <vector>

#include "app/live/find_cut.hpp"
#include "core/mesh/tetra_mesh.hpp"

/// Wounds inside of a body, and ways from there to its surface.
namespace livermark::live {

/// Cavities of a body that no way leads to: parts of its wound that share no edge with the rest of its surface, and
/// enclose a volume.
struct ClosedCavities {
    std::vector<char> is_at; ///< (N) nodes in their walls
    double volume = 0.0;     ///< of all together, at rest [m^3]
    double depth = 0.0; ///< smallest distance at rest from their walls to the rest of the surface [m]; 0 without any
};

ClosedCavities closed_cavities(const Remains &remains);

/// Tetrahedra of a channel by which a region can come out: a cylinder as wide as the region, from its middle to the
/// free surface. Of the channels to the places of the surface that are next to the region it is the one with the least
/// volume that touches nothing of what is constrained and takes nothing of other regions inside the body.
/// @param before          what earlier cuts have left
/// @param is_constrained  shape (T) of the boundary triangles of the whole mesh
/// @param taken           shape (M) of `before`, around the region: the channel hangs together with these
/// @param neighbours      shape (M, 4), see core::face_neighbours()
/// @return of `before`, none of those taken; empty if there is no such channel
std::vector<int> way_out(const Remains &before, const std::string &region, const std::vector<bool> &is_constrained,
                         const std::vector<bool> &taken, const std::vector<std::array<int, 4>> &neighbours);

} // namespace livermark::live
