#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <vector>

namespace livermark::core {

struct Body;
struct Foundation;
struct TetraMesh;

/// Spring between two points of one tetrahedron, of the energy stiffness / 2 (length - rest_length)^2. It is a fibre of
/// a vessel there, as other programs can have it: linear elements stretch all of a fibre alike.
struct VesselSpring {
    int tetrahedron = 0;
    std::array<Eigen::Vector4d, 2> ends; ///< barycentric
    double rest_length = 0.0;            ///< [m], > 0
    double stiffness = 0.0;              ///< [N/m], > 0
};

/// One for each passage of a fibre through a tetrahedron that has a stiffness, in the order of vessel_points(), whose
/// two points are its ends.
/// @return empty where the body has no vessels
std::vector<VesselSpring> vessel_springs(const Body &body);

/// Springs on edges that stand for the capsule of a body, those of capsule_springs().
struct CapsuleEdges {
    explicit CapsuleEdges(const Body &body);

    std::vector<std::array<int, 2>> nodes; ///< (S), none where the body has no capsule
    std::vector<double> stiffness;         ///< (S) [N/m], > 0
};

/// Stiffness of a foundation on nodes between which displacements are linear: the integral of N_a N_b over a facet of
/// the area A is A (1 + delta_ab) / 12.
/// @return shape (3 N, 3 N), symmetric, entry (3 a + i, 3 b + j) of components of nodes [N/m]
Eigen::SparseMatrix<double> foundation_stiffness(const TetraMesh &mesh, const Foundation &foundation);

/// Point with barycentric coordinates in a tetrahedron of a body [m].
Eigen::Vector3d point_in(const Body &body, int tetrahedron, const Eigen::Vector4d &coordinates);

} // namespace livermark::core
