#include "tests/samples/lagrange_elements.hpp"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <map>

namespace livermark::tests {

namespace {

using core::Vector3;

/// Corners of the edge that each midpoint node of a cell lies on, in the order of ElasticSystem::cell_nodes.
constexpr std::array<std::array<int, 2>, 6> midpoint_corners{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

/// Gauss points of four on [0, 1].
constexpr std::array<double, 4> gauss_node{0.069431844202973714, 0.330009478207571868, 0.669990521792428132,
                                           0.930568155797026286};
constexpr std::array<double, 4> gauss_weight{0.173927422568726929, 0.326072577431273071, 0.326072577431273071,
                                             0.173927422568726929};

struct QuadraturePoint {
    Eigen::Vector4d barycentric;
    double weight; ///< they sum to 1
};

/// The Gauss points of a cube, collapsed to a tetrahedron: exact to degree 5, and all weights are positive.
std::vector<QuadraturePoint> tetrahedron_quadrature() {
    std::vector<QuadraturePoint> points;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            for (int k = 0; k < 4; ++k) {
                const double x = gauss_node[i], y = gauss_node[j] * (1.0 - x), z = gauss_node[k] * (1.0 - x - y);
                points.push_back(
                    {{1.0 - x - y - z, x, y, z},
                     6.0 * gauss_weight[i] * gauss_weight[j] * gauss_weight[k] * (1.0 - x) * (1.0 - x - y)});
            }
    return points;
}

/// The same for the triangle of the first three corners.
std::vector<QuadraturePoint> triangle_quadrature() {
    std::vector<QuadraturePoint> points;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            const double x = gauss_node[i], y = gauss_node[j] * (1.0 - x);
            points.push_back({{1.0 - x - y, x, y, 0.0}, 2.0 * gauss_weight[i] * gauss_weight[j] * (1.0 - x)});
        }
    return points;
}

std::array<Vector3, 4> corners_of(const fem_reference::ElasticSystem &system, int cell) {
    std::array<Vector3, 4> corners;
    for (int v = 0; v < 4; ++v)
        corners[v] = system.points[system.cell_nodes[cell * system.nodes_per_cell + v]];
    return corners;
}

Vector3 point_at(const std::array<Vector3, 4> &corners, const Eigen::Vector4d &barycentric) {
    Vector3 point = Vector3::Zero();
    for (int v = 0; v < 4; ++v)
        point += barycentric[v] * corners[v];
    return point;
}

double volume_of(const std::array<Vector3, 4> &corners) {
    return core::signed_volume(corners[0], corners[1], corners[2], corners[3]);
}

int num_cells(const fem_reference::ElasticSystem &system) {
    return static_cast<int>(system.cell_nodes.size()) / system.nodes_per_cell;
}

std::array<int, 2> edge_key(int a, int b) {
    return {std::min(a, b), std::max(a, b)};
}

/// The midpoint node of each edge, by its ascending corners; empty for linear elements.
std::map<std::array<int, 2>, int> midpoint_nodes(const fem_reference::ElasticSystem &system) {
    std::map<std::array<int, 2>, int> midpoint;
    if (system.nodes_per_cell == 10)
        for (auto nodes = system.cell_nodes.begin(); nodes != system.cell_nodes.end(); nodes += 10)
            for (int e = 0; e < 6; ++e)
                midpoint[edge_key(nodes[midpoint_corners[e][0]], nodes[midpoint_corners[e][1]])] = nodes[4 + e];
    return midpoint;
}

Eigen::Matrix3d gradient_from(const fem_reference::ElasticSystem &system, int cell,
                              const Eigen::Matrix3Xd &shape_gradient, const std::vector<double> &displacement) {
    Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
    for (int a = 0; a < system.nodes_per_cell; ++a) {
        const int node = system.cell_nodes[cell * system.nodes_per_cell + a];
        gradient += Vector3::Map(&displacement[3 * node]) * shape_gradient.col(a).transpose();
    }
    return gradient;
}

} // namespace

Eigen::Matrix3d stress(const core::Material &material, const Eigen::Matrix3d &gradient) {
    return material.lame_lambda() * gradient.trace() * Eigen::Matrix3d::Identity() +
           material.shear_modulus() * (gradient + gradient.transpose());
}

Eigen::VectorXd shape_functions(int nodes_per_cell, const Eigen::Vector4d &barycentric) {
    if (nodes_per_cell == 4)
        return barycentric;
    Eigen::VectorXd shape(10);
    for (int v = 0; v < 4; ++v)
        shape[v] = barycentric[v] * (2.0 * barycentric[v] - 1.0);
    for (int e = 0; e < 6; ++e)
        shape[4 + e] = 4.0 * barycentric[midpoint_corners[e][0]] * barycentric[midpoint_corners[e][1]];
    return shape;
}

Eigen::Matrix<double, 3, 4> barycentric_gradients(const std::array<Vector3, 4> &corners) {
    Eigen::Matrix3d edges;
    for (int v = 0; v < 3; ++v)
        edges.row(v) = corners[v + 1] - corners[0];
    Eigen::Matrix<double, 3, 4> gradients;
    gradients.rightCols<3>() = edges.inverse();
    gradients.col(0) = -gradients.rightCols<3>().rowwise().sum();
    return gradients;
}

Eigen::Matrix3Xd shape_gradients(int nodes_per_cell, const Eigen::Vector4d &barycentric,
                                 const Eigen::Matrix<double, 3, 4> &corner_gradients) {
    if (nodes_per_cell == 4)
        return corner_gradients;
    Eigen::Matrix3Xd gradients(3, 10);
    for (int v = 0; v < 4; ++v)
        gradients.col(v) = (4.0 * barycentric[v] - 1.0) * corner_gradients.col(v);
    for (int e = 0; e < 6; ++e) {
        const auto [a, b] = midpoint_corners[e];
        gradients.col(4 + e) =
            4.0 * (barycentric[a] * corner_gradients.col(b) + barycentric[b] * corner_gradients.col(a));
    }
    return gradients;
}

Eigen::Matrix3d displacement_gradient(const fem_reference::ElasticSystem &system, int cell,
                                      const Eigen::Vector4d &barycentric, const std::vector<double> &displacement) {
    const auto corner_gradients = barycentric_gradients(corners_of(system, cell));
    return gradient_from(system, cell, shape_gradients(system.nodes_per_cell, barycentric, corner_gradients),
                         displacement);
}

void add_body_force(const fem_reference::ElasticSystem &system, const std::function<Vector3(const Vector3 &)> &force,
                    std::vector<double> &load) {
    for (const auto &[barycentric, weight] : tetrahedron_quadrature()) {
        const auto shape = shape_functions(system.nodes_per_cell, barycentric);
        for (int cell = 0; cell < num_cells(system); ++cell) {
            const auto corners = corners_of(system, cell);
            const Vector3 here = weight * volume_of(corners) * force(point_at(corners, barycentric));
            for (int a = 0; a < system.nodes_per_cell; ++a)
                Vector3::Map(&load[3 * system.cell_nodes[cell * system.nodes_per_cell + a]]) += shape[a] * here;
        }
    }
}

void add_traction(const fem_reference::ElasticSystem &system, const core::TetraMesh &mesh, const std::string &patch,
                  const std::function<Vector3(const Vector3 &)> &traction, std::vector<double> &load) {
    const auto midpoint = midpoint_nodes(system);
    const auto quadrature = triangle_quadrature();
    for (int facet = 0; facet < mesh.num_boundary_triangles(); ++facet) {
        if (mesh.patch_names[mesh.boundary_patch[facet]] != patch)
            continue;
        // The facet is a face of a cell whose fourth corner, and the edges to it, carry nothing.
        const auto &corners = mesh.boundary_triangles[facet];
        std::array<int, 10> nodes{corners[0], corners[1], corners[2], -1, -1, -1, -1, -1, -1, -1};
        if (system.nodes_per_cell == 10)
            for (int e = 0; e < 3; ++e)
                nodes[4 + e] = midpoint.at(edge_key(corners[midpoint_corners[e][0]], corners[midpoint_corners[e][1]]));
        const double area = core::area_vector(mesh, facet).norm();
        for (const auto &[barycentric, weight] : quadrature) {
            const auto shape = shape_functions(system.nodes_per_cell, barycentric);
            Vector3 point = Vector3::Zero();
            for (int v = 0; v < 3; ++v)
                point += barycentric[v] * mesh.points[corners[v]];
            const Vector3 here = weight * area * traction(point);
            for (int a = 0; a < system.nodes_per_cell; ++a)
                if (nodes[a] >= 0)
                    Vector3::Map(&load[3 * nodes[a]]) += shape[a] * here;
        }
    }
}

double mesh_size(const core::TetraMesh &mesh, int degree) {
    const auto volumes = core::tetrahedron_volumes(mesh);
    double sum = 0.0, volume = 0.0;
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        double longest = 0.0;
        for (const auto &[a, b] : core::tetrahedron_edges)
            longest =
                std::max(longest, (mesh.points[mesh.tetrahedra[t][a]] - mesh.points[mesh.tetrahedra[t][b]]).norm());
        sum += volumes[t] * std::pow(longest, 2.0 * degree);
        volume += volumes[t];
    }
    return std::pow(sum / volume, 0.5 / degree);
}

RelativeError relative_error(const fem_reference::ElasticSystem &system, const std::vector<double> &displacement,
                             const ElasticField &exact) {
    const auto quadrature = tetrahedron_quadrature();
    double error = 0.0, size = 0.0, gradient_error = 0.0, gradient_size = 0.0;
    for (int cell = 0; cell < num_cells(system); ++cell) {
        const auto corners = corners_of(system, cell);
        const auto corner_gradients = barycentric_gradients(corners);
        for (const auto &[barycentric, weight] : quadrature) {
            const auto shape = shape_functions(system.nodes_per_cell, barycentric);
            const auto shape_gradient = shape_gradients(system.nodes_per_cell, barycentric, corner_gradients);
            Vector3 found = Vector3::Zero();
            for (int a = 0; a < system.nodes_per_cell; ++a)
                found +=
                    shape[a] * Vector3::Map(&displacement[3 * system.cell_nodes[cell * system.nodes_per_cell + a]]);
            const Vector3 point = point_at(corners, barycentric);
            const Vector3 wanted = exact.displacement(point);
            const Eigen::Matrix3d gradient = exact.gradient(point);
            const double here = weight * volume_of(corners);
            error += here * (found - wanted).squaredNorm();
            size += here * wanted.squaredNorm();
            gradient_error +=
                here * (gradient_from(system, cell, shape_gradient, displacement) - gradient).squaredNorm();
            gradient_size += here * gradient.squaredNorm();
        }
    }
    return {std::sqrt(error / size), std::sqrt(gradient_error / gradient_size)};
}

} // namespace livermark::tests
