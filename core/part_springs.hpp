#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <cstddef>
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

/// Integral of N_a N_b over a triangle on whose corners displacements are linear, in parts of A / 12.
constexpr std::array<std::array<double, 3>, 3> linear_shares{{{2, 1, 1}, {1, 2, 1}, {1, 1, 2}}};

/// Adds the block shares[a][b] part for each pair of nodes, entry (3 a + i, 3 b + j) for their components.
template <std::size_t N>
void add_blocks(std::vector<Eigen::Triplet<double>> &entries, const std::array<int, N> &nodes,
                const std::array<std::array<double, N>, N> &shares, const Eigen::Matrix3d &part) {
    for (std::size_t a = 0; a < N; ++a)
        for (std::size_t b = 0; b < N; ++b)
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j)
                    entries.emplace_back(3 * nodes[a] + i, 3 * nodes[b] + j, shares[a][b] * part(i, j));
}

/// Stiffness of a foundation on nodes between which displacements are linear.
/// @return shape (3 N, 3 N), symmetric, entry (3 a + i, 3 b + j) of components of nodes [N/m]
Eigen::SparseMatrix<double> foundation_stiffness(const TetraMesh &mesh, const Foundation &foundation);

/// Point with barycentric coordinates in a tetrahedron of a body [m].
Eigen::Vector3d point_in(const Body &body, int tetrahedron, const Eigen::Vector4d &coordinates);

} // namespace livermark::core
