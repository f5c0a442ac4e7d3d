#include "fem_reference/linear/vessel_lines.hpp"

#include <array>

#include "core/mesh/places.hpp"
#include "fem_reference/linear/facets.hpp"

namespace livermark::fem_reference {

using core::Vector3;

namespace {

/// Ends of the edges whose midpoints are the nodes 4 to 9 of a cell.
constexpr std::array<std::array<int, 2>, 6> edge_of_midpoint{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

/// Slopes of the shape functions of Lagrange elements along a direction.
/// @param coordinates  barycentric, of the point
/// @param slope        of these coordinates along the direction [1/m]
/// @param num_nodes    4 or 10
Eigen::VectorXd shape_slopes(const Eigen::Vector4d &coordinates, const Eigen::Vector4d &slope, int num_nodes) {
    if (num_nodes == 4)
        return slope;
    Eigen::VectorXd slopes(num_nodes);
    slopes.head<4>() = (4.0 * coordinates.array() - 1.0) * slope.array();
    for (int k = 0; k < 6; ++k) {
        const auto [i, j] = edge_of_midpoint[static_cast<std::size_t>(k)];
        slopes[4 + k] = 4.0 * (coordinates[i] * slope[j] + coordinates[j] * slope[i]);
    }
    return slopes;
}

} // namespace

VesselLines::VesselLines(const core::Body &body, const ElasticSystem &system) {
    const auto num_nodes = static_cast<std::size_t>(system.nodes_per_cell);
    for (const auto &on_line : core::vessel_points(body)) {
        const auto t = static_cast<std::size_t>(on_line.tetrahedron);
        const auto slope = core::coordinate_slopes(body.mesh, body.mesh.tetrahedra[t], on_line.direction);
        const auto nodes = std::span(system.cell_nodes).subspan(t * num_nodes, num_nodes);
        points_.push_back(
            {on_line, {nodes.begin(), nodes.end()}, shape_slopes(on_line.coordinates, slope, system.nodes_per_cell)});
    }
}

Vector3 VesselLines::moved(const Point &point, std::span<const double> displacement) {
    Vector3 result = point.on_line.direction;
    if (!displacement.empty())
        for (std::size_t a = 0; a < point.nodes.size(); ++a)
            result += point.slope[static_cast<Eigen::Index>(a)] *
                      Vector3::Map(&displacement[3 * static_cast<std::size_t>(point.nodes[a])]);
    return result;
}

double VesselLines::add_force(std::span<const double> displacement, std::span<double> force,
                              std::span<const double> energy_share) const {
    double energy = 0.0;
    for (const auto &point : points_) {
        const Vector3 axis = moved(point, displacement), pull = point.on_line.pull(axis);
        const double share =
            energy_share.empty() ? 1.0 : energy_share[static_cast<std::size_t>(point.on_line.tetrahedron)];
        energy += share * point.on_line.energy(axis);
        for (std::size_t a = 0; a < point.nodes.size(); ++a)
            Vector3::Map(&force[3 * static_cast<std::size_t>(point.nodes[a])]) +=
                point.slope[static_cast<Eigen::Index>(a)] * pull;
    }
    return energy;
}

void VesselLines::add_stiffness(std::span<const double> displacement, SymmetricBlocks<double> &stiffness) const {
    for (const auto &point : points_) {
        const Eigen::Matrix3d block = point.on_line.stiffness(moved(point, displacement));
        const auto num_nodes = static_cast<Eigen::Index>(point.nodes.size());
        Eigen::MatrixXd local(3 * num_nodes, 3 * num_nodes);
        for (Eigen::Index a = 0; a < num_nodes; ++a)
            for (Eigen::Index b = 0; b < num_nodes; ++b)
                local.block<3, 3>(3 * a, 3 * b) = point.slope[a] * point.slope[b] * block;
        add_to(stiffness, point.nodes, local);
    }
}

} // namespace livermark::fem_reference
