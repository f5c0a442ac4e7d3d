#include "core/part_springs.hpp"

#include <cstddef>

#include "core/capsule.hpp"
#include "core/problem.hpp"
#include "core/vessels.hpp"

namespace livermark::core {

Eigen::Vector3d point_in(const Body &body, int tetrahedron, const Eigen::Vector4d &coordinates) {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 4; ++k) {
        const auto node = body.mesh.tetrahedra[static_cast<std::size_t>(tetrahedron)][k];
        point += coordinates[static_cast<Eigen::Index>(k)] * body.mesh.points[static_cast<std::size_t>(node)];
    }
    return point;
}

std::vector<VesselSpring> vessel_springs(const Body &body) {
    std::vector<VesselSpring> springs;
    const auto points = vessel_points(body);
    for (std::size_t p = 0; p + 1 < points.size(); p += 2) {
        const auto &first = points[p], &second = points[p + 1];
        const double length = (point_in(body, second.tetrahedron, second.coordinates) -
                               point_in(body, first.tetrahedron, first.coordinates))
                                  .norm();
        const double weight = first.weight + second.weight;
        if (weight > 0.0)
            springs.push_back({.tetrahedron = first.tetrahedron,
                               .ends = {first.coordinates, second.coordinates},
                               .rest_length = length,
                               .stiffness = weight / (length * length)});
    }
    return springs;
}

Eigen::SparseMatrix<double> foundation_stiffness(const TetraMesh &mesh, const Foundation &foundation) {
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t which = 0; which < foundation.facets.size(); ++which) {
        const int facet = foundation.facets[which];
        add_blocks(entries, mesh.boundary_triangles[facet], linear_shares,
                   area_vector(mesh, facet).norm() / 12.0 * foundation.stiffness_on(mesh, which));
    }
    const auto size = static_cast<Eigen::Index>(3 * mesh.points.size());
    Eigen::SparseMatrix<double> stiffness(size, size);
    stiffness.setFromTriplets(entries.begin(), entries.end());
    return stiffness;
}

CapsuleEdges::CapsuleEdges(const Body &body) {
    if (!body.capsule)
        return;
    const auto table = edge_table(body.mesh.tetrahedra);
    const auto added = capsule_springs(body, table);
    for (std::size_t e = 0; e < added.size(); ++e)
        if (added[e] > 0.0) {
            nodes.push_back(table.edges[e]);
            stiffness.push_back(added[e]);
        }
}

} // namespace livermark::core
