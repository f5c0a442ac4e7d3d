#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace livermark::core {

using Vector3 = Eigen::Vector3d;

/// A body cut into linear tetrahedra. The node numbering is that of the mesh file; every result is given in it.
struct TetraMesh {
    std::vector<Vector3> points;                        ///< (N) node coordinates [m]
    std::vector<std::array<int, 4>> tetrahedra;         ///< (M) node numbers, positive volume
    std::vector<int> region;                            ///< (M) index into region_names
    std::vector<std::string> region_names;              ///< (R) one per material
    std::vector<std::array<int, 3>> boundary_triangles; ///< (T) node numbers, right-handed seen from outside
    std::vector<int> boundary_patch;                    ///< (T) index into patch_names
    std::vector<std::string> patch_names;               ///< named parts of the boundary

    int num_nodes() const { return static_cast<int>(points.size()); }
    int num_tetrahedra() const { return static_cast<int>(tetrahedra.size()); }
    int num_boundary_triangles() const { return static_cast<int>(boundary_triangles.size()); }
};

/// Local node numbers of the six edges of a tetrahedron.
inline constexpr std::array<std::array<int, 2>, 6> tetrahedron_edges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// Local node numbers of the four faces, right-handed seen from outside a tetrahedron of positive volume.
inline constexpr std::array<std::array<int, 3>, 4> tetrahedron_faces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// Signed volume of the tetrahedron a b c d [m^3], positive when d sees a b c anticlockwise from inside.
double signed_volume(const Vector3 &a, const Vector3 &b, const Vector3 &c, const Vector3 &d);

/// Volume of each tetrahedron.
/// @return shape (M) [m^3]
std::vector<double> tetrahedron_volumes(const TetraMesh &mesh);

/// Barycentric volume of each node, V_i = 1/4 sum over the tetrahedra t at node i of V(t).
/// @return shape (N) [m^3]; the sum is the volume of the body
std::vector<double> nodal_volumes(const TetraMesh &mesh);

/// The faces that belong to one tetrahedron only, each once and right-handed seen from outside, in the order of the
/// tetrahedra.
std::vector<std::array<int, 3>> outer_faces(std::span<const std::array<int, 4>> tetrahedra);

/// Area vector of a boundary triangle: its outward normal times its area.
/// @param triangle  index into mesh.boundary_triangles
/// @return [m^2]
Vector3 area_vector(const TetraMesh &mesh, int triangle);

/// The edges of a mesh, each once, and where every tetrahedron finds its six.
struct EdgeTable {
    std::vector<std::array<int, 2>> edges;            ///< (S) lower node number first, in lexicographic order
    std::vector<std::array<int, 6>> tetrahedron_edge; ///< (M) index into edges, in the order of tetrahedron_edges
};

EdgeTable edge_table(std::span<const std::array<int, 4>> tetrahedra);

/// The smallest box along the axes that holds all points [m]; empty if there are none.
inline Eigen::AlignedBox3d bounding_box(std::span<const Vector3> points) {
    Eigen::AlignedBox3d box;
    for (const auto &point : points)
        box.extend(point);
    return box;
}

/// Diagonal of the box around some points [m].
/// @param points  at least one
inline double extent(std::span<const Vector3> points) {
    return bounding_box(points).diagonal().norm();
}

/// The point of a segment that is nearest to a point [m].
/// @param from, to  its ends, apart
inline Vector3 nearest_of_segment(const Vector3 &from, const Vector3 &to, const Vector3 &point) {
    const Vector3 side = to - from;
    return from + std::clamp((point - from).dot(side) / side.squaredNorm(), 0.0, 1.0) * side;
}

/// The point of a triangle that is nearest to a point [m]: its foot on the plane if that is inside, else the nearest
/// point of the sides.
/// @param corners  not on one line
inline Vector3 nearest_of_triangle(const std::array<Vector3, 3> &corners, const Vector3 &point) {
    const Vector3 area = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    const Vector3 foot = point - area * area.dot(point - corners[0]) / area.squaredNorm();
    bool is_inside = true;
    Vector3 nearest = corners[0];
    for (std::size_t k = 0; k < 3; ++k) {
        const Vector3 &from = corners[k], &to = corners[(k + 1) % 3];
        is_inside = is_inside && (to - from).cross(foot - from).dot(area) >= 0.0;
        if (const Vector3 candidate = nearest_of_segment(from, to, point);
            (candidate - point).squaredNorm() < (nearest - point).squaredNorm())
            nearest = candidate;
    }
    return is_inside ? foot : nearest;
}

/// The nodes of a face in ascending order: the same from both sides.
std::array<int, 3> face_key(std::array<int, 3> nodes);

/// @param face  as in tetrahedron_faces
std::array<int, 3> face_key(const std::array<int, 4> &tetrahedron, std::size_t face);

/// A face of a tetrahedron.
struct TetrahedronFace {
    std::array<int, 3> nodes; ///< ascending
    int tetrahedron = 0;
    int face = 0; ///< as in tetrahedron_faces
    auto operator<=>(const TetrahedronFace &) const = default;
};

/// The faces of all tetrahedra in ascending order, so that what two of them share stands side by side.
/// @return shape (4 M)
std::vector<TetrahedronFace> sorted_faces(std::span<const std::array<int, 4>> tetrahedra);

/// The nodes of a face of more than two tetrahedra; nothing if there is none.
/// @param sorted  as above
std::optional<std::array<int, 3>> face_of_too_many(std::span<const TetrahedronFace> sorted);

/// Neighbour on the other side of each face of each tetrahedron.
/// @return shape (M, 4), faces as in tetrahedron_faces: number of a tetrahedron, -1 outside of all
std::vector<std::array<int, 4>> face_neighbours(std::span<const std::array<int, 4>> tetrahedra);

/// The tetrahedra that have each node as a corner, ascending. @return (N)
std::vector<std::vector<int>> tetrahedra_at_nodes(const TetraMesh &mesh);

/// Patches that share facets. A facet has one index into TetraMesh::patch_names; where it lies in two patches, such as
/// one of the file and one that was found, that name has both with a '+' between them: "back+posterior".

inline constexpr char patch_joint = '+';

/// Name of the patch of the facets that a cut has opened.
inline constexpr const char *wound_patch = "wound";

/// Whether a name of TetraMesh::patch_names is that of a patch, or has it among those that it joins.
bool is_in_patch(std::string_view name_of_facet, std::string_view patch);

/// Each patch of a mesh once, in the order of its names.
std::vector<std::string> patches_of(const TetraMesh &mesh);

/// The facets of a patch, in ascending order; none if the mesh has no such patch.
std::vector<int> facets_in_patch(const TetraMesh &mesh, std::string_view patch);

/// Parts of tetrahedra that hang together by faces.
/// @param are_joined  whether two with a common face hang together by it; all do if it is empty
/// @return shape (M) the part of each tetrahedron, numbered as their first tetrahedra come
std::vector<int> parts_by_faces(std::span<const std::array<int, 4>> tetrahedra,
                                const std::function<bool(int, int)> &are_joined = {});

/// Two nodes in one place, to within 1e-9 of the extent of all; nothing if there are none.
/// @param is_meant  whether two of them may be, as on both sides of a cut; none may if it is empty
std::optional<std::pair<int, int>> nodes_in_one_place(std::span<const Vector3> points,
                                                      const std::function<bool(int, int)> &is_meant = {});

/// Two tetrahedra of the same nodes, the first in front; nothing if there are none.
std::optional<std::pair<int, int>> tetrahedra_of_same_nodes(std::span<const std::array<int, 4>> tetrahedra);

} // namespace livermark::core
