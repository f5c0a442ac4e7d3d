#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <span>
#include <string>
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

} // namespace livermark::core
