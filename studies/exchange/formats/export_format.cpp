#include "studies/exchange/formats/export_format.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace livermark::exchange {

namespace {

/// The corners of each midpoint of a C3D10, in CalculiX's order.
constexpr std::array<std::array<int, 2>, 6> midpoint_corners{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

} // namespace

using core::Vector3;

Discretisation discretise(const core::TetraMesh &mesh, int degree) {
    Discretisation fem{mesh.points, {}, {}};
    const auto table = core::edge_table(mesh.tetrahedra);
    const auto midpoint = [&](int a, int b) {
        const std::array<int, 2> edge{std::min(a, b), std::max(a, b)};
        return mesh.num_nodes() + static_cast<int>(std::ranges::lower_bound(table.edges, edge) - table.edges.begin());
    };
    if (degree == 2)
        for (const auto &[a, b] : table.edges)
            fem.points.emplace_back(0.5 * (mesh.points[a] + mesh.points[b]));
    for (const auto &corners : mesh.tetrahedra) {
        auto &nodes = fem.elements.emplace_back(corners.begin(), corners.end());
        if (degree == 2)
            for (const auto &[a, b] : midpoint_corners)
                nodes.push_back(midpoint(corners[a], corners[b]));
    }
    for (const auto &corners : mesh.boundary_triangles) {
        auto &nodes = fem.facets.emplace_back(corners.begin(), corners.end());
        if (degree == 2)
            for (int v = 0; v < 3; ++v)
                nodes.push_back(midpoint(corners[v], corners[(v + 1) % 3]));
    }
    return fem;
}

std::vector<Vector3> prescribed_displacement(const core::LoadCase &load_case, const Discretisation &fem) {
    std::vector<Vector3> value(fem.points.size(), Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
    for (int constraint = 0; constraint < load_case.num_constraints(); ++constraint)
        for (int f = 0; f < load_case.num_facets(); ++f)
            if (load_case.constraint_on(f) == constraint && !load_case.presses(f))
                for (std::size_t k = 0; k < fem.facets[f].size(); ++k) {
                    const auto &nodes = fem.facets[f];
                    const int a = nodes[k % 3], b = k < 3 ? a : nodes[(k + 1) % 3];
                    const Vector3 prescribed = 0.5 * (load_case.prescribed_at(f, a) + load_case.prescribed_at(f, b));
                    for (int i = 0; i < 3; ++i)
                        if (std::isnan(value[nodes[k]][i]))
                            value[nodes[k]][i] = prescribed[i];
                }
    return value;
}

std::vector<Vector3> traction_forces(const core::TetraMesh &mesh, const core::LoadCase &load_case,
                                     const Discretisation &fem) {
    std::vector<Vector3> force(fem.points.size(), Vector3::Zero());
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.is_loaded(f)) {
            const Vector3 whole = core::area_vector(mesh, f).norm() * load_case.value[f];
            const auto *load = load_case.round_load_on(f);
            const auto corners = core::corners_of(mesh, f);
            const auto &nodes = fem.facets[f];
            const auto share = [&](const auto &parts) {
                for (std::size_t k = 0; k < parts.size(); ++k)
                    for (int i = 0; i < 3; ++i)
                        if (!std::isnan(whole[i]))
                            force[nodes[k]][i] += parts[k] * whole[i];
            };
            nodes.size() == 3 ? share(core::linear_parts(load, corners)) : share(core::quadratic_parts(load, corners));
        }
    return force;
}

std::vector<Vector3> nodal_forces(const core::Problem &problem, const Discretisation &fem) {
    const auto &mesh = problem.body->mesh;
    auto force = traction_forces(mesh, problem.load_case, fem);
    const auto volumes = core::tetrahedron_volumes(mesh);
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        for (const int node : mesh.tetrahedra[t])
            force[node] +=
                0.25 * problem.body->materials[mesh.region[t]].density * volumes[t] * problem.load_case.acceleration;
    return force;
}

} // namespace livermark::exchange
