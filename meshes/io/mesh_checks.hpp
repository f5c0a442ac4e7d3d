#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

/// Size and quality of a mesh. Quality is a performance feature: the shortest edge sets the time step of all.
struct MeshFigures {
    int num_tetrahedra = 0;
    int num_nodes = 0;
    int num_edges = 0;
    double volume = 0.0;                    ///< [m^3]
    core::Vector3 extent = {0.0, 0.0, 0.0}; ///< of the bounding box [m]
    double mean_edge = 0.0;                 ///< [m]
    double shortest_edge = 0.0;             ///< [m]
    double smallest_quality = 0.0;          ///< min over tetrahedra of 6 sqrt(2) V / l_rms^3; 1 for a regular one
};

/// Lists of what hangs together, each in the order in which a search from its first item comes to the others.
/// @param is_left   (n) items to list
/// @param touching  (item, visit) calls visit(other) for each other item that hangs on it
template <class Touching>
std::vector<std::vector<int>> parts_that_touch(std::vector<bool> is_left, const Touching &touching) {
    std::vector<std::vector<int>> parts;
    for (int first = 0; first < std::ssize(is_left); ++first) {
        if (!is_left[first])
            continue;
        auto &part = parts.emplace_back();
        const auto visit = [&](int item) {
            if (is_left[item])
                part.push_back(item);
            is_left[item] = false;
        };
        visit(first);
        for (std::size_t at = 0; at < part.size(); ++at)
            touching(part[at], visit);
    }
    return parts;
}

/// 6 sqrt(2) V / l_rms^3 with l_rms the root mean square of the six edges: 1 for a regular tetrahedron, 0 for a flat
/// one.
double tetrahedron_quality(const core::Vector3 &a, const core::Vector3 &b, const core::Vector3 &c,
                           const core::Vector3 &d);

MeshFigures mesh_figures(const core::TetraMesh &mesh);

/// The figures as lines of "name value unit", for people.
std::string to_text(const MeshFigures &figures);

/// Takes the names out that no element has; the others keep their order.
/// @param groups  of each element the index into names, which follows them
/// @return the former indices of the names that stay
std::vector<int> keep_used_groups(std::vector<int> &groups, std::vector<std::string> &names);

/// Contents of a mesh file, before anything is believed. Node numbers are indices into points; the tags are the file's
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

/// Every node is finite, used, and the only one at its place, other than in the patch "wound": a body that was parted
/// has nodes of both sides there.
/// @throws support::InputError that names the first that is not
void check_nodes(const RawMesh &raw, const std::string &file);

/// There are tetrahedra, every one has four corners and a positive volume, and none is there twice.
/// @throws support::InputError that names the first that is not so
void check_tetrahedra(const RawMesh &raw, const std::string &file);

/// Every face belongs to one or two tetrahedra, every triangle of the file is a face, and the tetrahedra hang together
/// by faces.
/// @throws support::InputError that names the first that is not so
void check_faces(const RawMesh &raw, const std::string &file);

} // namespace livermark::meshes
