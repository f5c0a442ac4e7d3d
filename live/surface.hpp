#pragma once

#include <array>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/tool/round_load.hpp"

namespace livermark::live {

/// What of a body can be touched: boundary triangles that are not constrained.
struct Surface {
    std::vector<std::array<int, 3>> triangles; ///< (L) node numbers of the mesh, right-handed seen from outside
    std::vector<int> facet;                    ///< (L) which boundary triangles of the mesh these are
    std::vector<double> area;                  ///< (L) at rest [m^2]
    std::vector<int> nodes;                    ///< of these triangles, each once, ascending
    std::vector<double> nodal_area;            ///< (N) a third of the triangles around each node of the mesh [m^2]
};

/// @param is_constrained  shape (T), which boundary triangles cannot move
Surface touchable_surface(const core::TetraMesh &mesh, const std::vector<bool> &is_constrained);

/// Forces of a tool on a body.
struct Load {
    std::vector<core::Vector3> nodal;            ///< (N) [N]; zero but at the nodes
    std::vector<int> nodes;                      ///< that may be loaded, each once
    std::vector<core::Vector3> facet;            ///< (L) of each triangle of the surface [N]; zero but at the triangles
    std::vector<int> triangles;                  ///< that are loaded, each once
    core::Vector3 total = core::Vector3::Zero(); ///< [N]
    /// How the force is spread, with the resultant `total`; looked at where there are triangles alone.
    core::RoundLoad shape;
};

/// No load on anything.
Load no_load(const Surface &surface);

/// Takes the forces off.
void clear(Load &load);

} // namespace livermark::live
