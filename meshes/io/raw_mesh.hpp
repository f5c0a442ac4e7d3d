#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

/// What a mesh file says, before anything is believed. Node numbers are indices into points; the tags are the file's
/// own numbers and are kept to name places in messages.
struct RawMesh {
    std::vector<core::Vector3> points;          ///< (N) [m]
    std::vector<std::int64_t> node_tag;         ///< (N)
    std::vector<std::array<int, 4>> tetrahedra; ///< (M)
    std::vector<std::int64_t> tetrahedron_tag;  ///< (M)
    std::vector<int> region_tag;                ///< (M) physical group, 0 = none
    std::vector<std::array<int, 3>> triangles;  ///< boundary or interface, any orientation
    std::vector<int> patch_tag;                 ///< physical group of each triangle, 0 = none
    std::map<int, std::string> region_names;    ///< by physical group
    std::map<int, std::string> patch_names;     ///< by physical group
    std::vector<std::string> remarks;           ///< a sentence for what was chosen among groups, or is left out
};

/// Takes triangles out that are no face of a tetrahedron, as of a surface that was drawn inside, and says so.
void leave_out_stray_triangles(RawMesh &raw);

/// Checks a raw mesh and makes a mesh of it: the boundary is found from the tetrahedra, the triangles of the file give
/// it its patches. Boundary that no triangle names is the patch "unnamed"; tetrahedra of no group are the region
/// "unnamed".
/// @param file  named in messages
/// @throws support::InputError with the first fault: no tetrahedra, a coordinate that is not finite, a tetrahedron that
/// is
///         inverted, flat or there twice, a node that is unused or there twice, more than two tetrahedra at a face,
///         several parts, a triangle that is no face or lies in two patches
core::TetraMesh assemble_mesh(const RawMesh &raw, const std::string &file);

} // namespace livermark::meshes
