#include "interactive/elements/quadratic_tetrahedra.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "interactive/elements/energies.hpp"

namespace livermark::interactive {

namespace {

constexpr int num_points = QuadraticTetrahedron::num_points;

/// Barycentric coordinates of a quadrature point: that of its own corner, and of the other three.
constexpr double root_5 = 2.236067977499789696409;
constexpr double near = (5.0 + 3.0 * root_5) / 20.0, far = (5.0 - root_5) / 20.0;

/// The place among the ten nodes of the middle between two corners.
constexpr std::array<std::array<int, 4>, 4> middle_of{{{-1, 4, 5, 6}, {4, -1, 7, 8}, {5, 7, -1, 9}, {6, 8, 9, -1}}};

/// Corners to points or back: the matrix of barycentric coordinates is symmetric.
QuadraticTetrahedron::AtPoints mixed(const QuadraticTetrahedron::AtPoints &of) {
    const Matrix3 shared = far * (of[0] + of[1] + of[2] + of[3]);
    QuadraticTetrahedron::AtPoints result;
    for (int k = 0; k < num_points; ++k)
        result[k] = shared + (near - far) * of[k];
    return result;
}

} // namespace

QuadraticTetrahedron::AtPoints QuadraticTetrahedron::gradients(const Field &x) const {
    AtPoints edges; // so that those at a corner, times B, are F there
    for (int k = 0; k < 4; ++k) {
        std::array<core::Vector3, 4> c;
        for (int j = 0; j < 4; ++j)
            c[j] = j == k ? core::Vector3(3.0 * x.col(nodes[k]))
                          : core::Vector3(4.0 * x.col(nodes[middle_of[k][j]]) - x.col(nodes[j]));
        for (int j = 0; j < 3; ++j)
            edges[k].col(j) = c[j + 1] - c[0];
    }
    AtPoints f = mixed(edges);
    for (auto &point_value : f)
        point_value *= inverse_edges;
    return f;
}

void QuadraticTetrahedron::add_forces(const AtPoints &stresses, Field &f) const {
    AtPoints scaled;
    for (int q = 0; q < num_points; ++q)
        scaled[q] = weight() * stresses[q] * inverse_edges.transpose();
    const AtPoints at_corners = mixed(scaled);
    for (int k = 0; k < 4; ++k) {
        std::array<core::Vector3, 4> c; // dW/dc of gradients()
        c[0] = -at_corners[k].rowwise().sum();
        for (int j = 0; j < 3; ++j)
            c[j + 1] = at_corners[k].col(j);
        for (int j = 0; j < 4; ++j)
            if (j == k) {
                f.col(nodes[k]) -= 3.0 * c[k];
            } else {
                f.col(nodes[middle_of[k][j]]) -= 4.0 * c[j];
                f.col(nodes[j]) += c[j];
            }
    }
}

Eigen::Matrix<double, 10, 3> QuadraticTetrahedron::shape_gradients(int point) const {
    Eigen::Matrix<double, 4, 3> linear;
    linear.bottomRows<3>() = inverse_edges;
    linear.row(0) = -inverse_edges.colwise().sum();
    const auto barycentric = [point](int corner) { return corner == point ? near : far; };
    Eigen::Matrix<double, 10, 3> gradients;
    for (int a = 0; a < 4; ++a)
        gradients.row(a) = (4.0 * barycentric(a) - 1.0) * linear.row(a);
    for (int e = 0; e < 6; ++e) {
        const auto [a, b] = core::tetrahedron_edges[e];
        gradients.row(4 + e) = 4.0 * (barycentric(a) * linear.row(b) + barycentric(b) * linear.row(a));
    }
    return gradients;
}

Eigen::Matrix<double, 30, 30> QuadraticTetrahedron::stiffness(const Field &x, bool is_projected) const {
    const auto f = gradients(x);
    const densities::NeoHookean density{mu, lambda};
    Eigen::Matrix<double, 30, 30> matrix = Eigen::Matrix<double, 30, 30>::Zero();
    for (int q = 0; q < num_points; ++q) {
        densities::Tangent tangent = density.tangent(f[q]);
        if (is_projected)
            tangent = densities::semi_definite_part(tangent);
        const auto slopes = shape_gradients(q);
        Eigen::Matrix<double, 30, 9> strain; // dF of unit moves
        for (int a = 0; a < 10; ++a)
            for (int j = 0; j < 3; ++j)
                strain.block<3, 3>(3 * a, 3 * j) = slopes(a, j) * Matrix3::Identity();
        matrix.noalias() += weight() * strain * tangent * strain.transpose();
    }
    return matrix;
}

QuadraticEnergy::QuadraticEnergy(const Scene &scene) {
    const auto table = core::edge_table(scene.body->mesh.tetrahedra);
    const int num_corners = scene.body->mesh.num_nodes();
    const auto linear = tetrahedra_at_rest(*scene.body);
    for (std::size_t t = 0; t < linear.size(); ++t) {
        QuadraticTetrahedron element{.nodes = {},
                                     .inverse_edges = linear[t].inverse_edges,
                                     .volume = linear[t].volume,
                                     .mu = linear[t].mu,
                                     .lambda = linear[t].lambda};
        std::ranges::copy(linear[t].nodes, element.nodes.begin());
        for (int e = 0; e < 6; ++e)
            element.nodes[4 + e] = num_corners + table.tetrahedron_edge[t][e];
        tetrahedra_.push_back(element);
    }
}

double QuadraticEnergy::value(const Field &x) const {
    double value = 0.0;
    for (const auto &t : tetrahedra_)
        for (const auto &f : t.gradients(x))
            value += t.weight() * densities::NeoHookean{t.mu, t.lambda}.value(f);
    return value;
}

void QuadraticEnergy::add_forces(const Field &x, Field &f) const {
    for (const auto &t : tetrahedra_) {
        auto at_points = t.gradients(x);
        for (auto &point_value : at_points)
            point_value = densities::NeoHookean{t.mu, t.lambda}.stress(point_value);
        t.add_forces(at_points, f);
    }
}

void QuadraticEnergy::add_hessian(const Field &x, bool is_projected, Triplets &triplets) const {
    triplets.reserve(triplets.size() + 900 * tetrahedra_.size());
    for (const auto &t : tetrahedra_) {
        const auto matrix = t.stiffness(x, is_projected);
        for (int i = 0; i < 30; ++i)
            for (int j = 0; j < 30; ++j)
                triplets.emplace_back(3 * t.nodes[i / 3] + i % 3, 3 * t.nodes[j / 3] + j % 3, matrix(i, j));
    }
}

namespace {

constexpr double corner_part = 1.0 / 36.0, edge_part = 4.0 / 27.0;

std::vector<double> volumes_around(const core::TetraMesh &mesh, const std::vector<double> &volumes) {
    std::vector<double> around(mesh.points.size(), 0.0);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        for (const int node : mesh.tetrahedra[t])
            around[node] += volumes[t];
    return around;
}

std::vector<double> lumped(const core::TetraMesh &mesh, const core::EdgeTable &table,
                           const std::vector<double> &node_mass) {
    const auto volumes = core::tetrahedron_volumes(mesh);
    const auto around = volumes_around(mesh, volumes);
    std::vector<double> masses(mesh.points.size() + table.edges.size(), 0.0);
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        double mass = 0.0;
        for (const int node : mesh.tetrahedra[t])
            mass += node_mass[node] * volumes[t] / around[node];
        for (const int node : mesh.tetrahedra[t])
            masses[node] += corner_part * mass;
        for (const int edge : table.tetrahedron_edge[t])
            masses[mesh.points.size() + edge] += edge_part * mass;
    }
    return masses;
}

/// The middles of edges of boundary triangles whose corners are all constrained.
std::vector<Follower> followers(const Scene &scene, const core::EdgeTable &table) {
    const auto &mesh = scene.body->mesh;
    std::vector<int> place(mesh.points.size(), -1);
    for (std::size_t c = 0; c < scene.constrained_nodes.size(); ++c)
        place[scene.constrained_nodes[c]] = static_cast<int>(c);
    std::map<std::array<int, 2>, int> number;
    for (std::size_t e = 0; e < table.edges.size(); ++e)
        number[table.edges[e]] = static_cast<int>(e);
    std::map<int, Follower> found;
    for (const auto &corners : mesh.boundary_triangles)
        if (std::ranges::all_of(corners, [&](int corner) { return place[corner] >= 0; }))
            for (int a = 0; a < 3; ++a) {
                const int from = corners[a], to = corners[(a + 1) % 3];
                const int node = mesh.num_nodes() + number.at({std::min(from, to), std::max(from, to)});
                found.try_emplace(node, Follower{node, {place[from], place[to]}});
            }
    std::vector<Follower> result;
    for (const auto &[node, follower] : found)
        result.push_back(follower);
    return result;
}

} // namespace

Scene quadratic_scene(Scene scene) {
    const auto &mesh = scene.body->mesh;
    const auto table = core::edge_table(mesh.tetrahedra);
    scene.node_mass = lumped(mesh, table, scene.node_mass);
    scene.followers = followers(scene, table);
    for (const auto &[a, b] : table.edges)
        scene.own_nodes.emplace_back(0.5 * (mesh.points[a] + mesh.points[b]));
    return scene;
}

} // namespace livermark::interactive
