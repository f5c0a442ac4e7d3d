#include "exchange/calculix_input.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/ostream.h>
#include <limits>
#include <ostream>
#include <vector>

namespace livermark::exchange {

namespace {

using core::Vector3;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// The corners of each midpoint of a C3D10, in CalculiX's order.
constexpr std::array<std::array<int, 2>, 6> midpoint_corners{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

/// Nodes of elements and facets as CalculiX wants them, counted from 0.
struct Discretisation {
    std::vector<Vector3> points;
    std::vector<std::vector<int>> elements; ///< (M) 4 or 10 nodes
    std::vector<std::vector<int>> facets;   ///< (T) 3 corners, then 3 midpoints
};

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

/// The value that each component of each node is held at, NaN where it is free. Where constraints meet, the one of
/// lowest index wins, as it does for every model.
std::vector<Vector3> prescribed_values(const core::LoadCase &load_case, const Discretisation &fem) {
    std::vector<Vector3> value(fem.points.size(), Vector3::Constant(nan));
    for (int constraint = 0; constraint < static_cast<int>(load_case.constraint_names.size()); ++constraint)
        for (std::size_t f = 0; f < fem.facets.size(); ++f)
            if (load_case.constraint[f] == constraint)
                for (const int node : fem.facets[f])
                    for (int i = 0; i < 3; ++i)
                        if (std::isnan(value[node][i]))
                            value[node][i] = load_case.value[f][i];
    return value;
}

/// A constant traction on a straight triangle acts in thirds on the corners of linear elements; of quadratic ones the
/// corners' shape functions have no mean over a face, and the midpoints get a third each.
std::vector<Vector3> nodal_forces(const core::TetraMesh &mesh, const core::LoadCase &load_case,
                                  const Discretisation &fem) {
    std::vector<Vector3> force(fem.points.size(), Vector3::Zero());
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.condition[f] == core::FacetCondition::traction) {
            const Vector3 third = core::area_vector(mesh, f).norm() / 3.0 * load_case.value[f];
            for (auto node = fem.facets[f].end() - 3; node != fem.facets[f].end(); ++node)
                for (int i = 0; i < 3; ++i)
                    force[*node][i] += std::isnan(third[i]) ? 0.0 : third[i];
        }
    return force;
}

} // namespace

// CalculiX reads the first twenty characters of a number, so thirteen digits have to do.
void write_inp(std::ostream &out, const core::Problem &problem, int degree) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    const auto fem = discretise(mesh, degree);
    fmt::print(out, "** body {}, load case {}\n*NODE, NSET=ALL_NODES\n", problem.body->name, load_case.name);
    for (std::size_t node = 0; node < fem.points.size(); ++node)
        fmt::print(out, "{}, {:.12e}, {:.12e}, {:.12e}\n", node + 1, fem.points[node].x(), fem.points[node].y(),
                   fem.points[node].z());
    for (std::size_t region = 0; region < mesh.region_names.size(); ++region) {
        fmt::print(out, "** {}\n*ELEMENT, TYPE={}, ELSET=REGION_{}\n", mesh.region_names[region],
                   degree == 1 ? "C3D4" : "C3D10", region);
        for (std::size_t t = 0; t < fem.elements.size(); ++t)
            if (mesh.region[t] == static_cast<int>(region)) {
                fmt::print(out, "{}", t + 1);
                for (const int node : fem.elements[t])
                    fmt::print(out, ", {}", node + 1);
                fmt::print(out, "\n");
            }
        const auto &material = problem.body->materials[region];
        fmt::print(out,
                   "*MATERIAL, NAME=MATERIAL_{0}\n*ELASTIC\n{1:.12e}, {2:.12e}\n*DENSITY\n{3:.12e}\n"
                   "*SOLID SECTION, ELSET=REGION_{0}, MATERIAL=MATERIAL_{0}\n",
                   region, material.young_modulus, material.poisson_ratio, material.density);
    }
    fmt::print(out, "*STEP\n*STATIC\n*BOUNDARY\n");
    const auto prescribed = prescribed_values(load_case, fem);
    for (std::size_t node = 0; node < prescribed.size(); ++node)
        for (int i = 0; i < 3; ++i)
            if (!std::isnan(prescribed[node][i]))
                fmt::print(out, "{}, {}, {}, {:.12e}\n", node + 1, i + 1, i + 1, prescribed[node][i]);
    fmt::print(out, "*CLOAD\n");
    const auto force = nodal_forces(mesh, load_case, fem);
    for (std::size_t node = 0; node < force.size(); ++node)
        for (int i = 0; i < 3; ++i)
            if (force[node][i] != 0.0)
                fmt::print(out, "{}, {}, {:.12e}\n", node + 1, i + 1, force[node][i]);
    if (const double size = load_case.acceleration.norm(); size > 0.0) {
        const Vector3 direction = load_case.acceleration / size;
        fmt::print(out, "*DLOAD\n");
        for (std::size_t region = 0; region < mesh.region_names.size(); ++region)
            fmt::print(out, "REGION_{}, GRAV, {:.12e}, {:.12e}, {:.12e}, {:.12e}\n", region, size, direction.x(),
                       direction.y(), direction.z());
    }
    fmt::print(out, "*NODE PRINT, NSET=ALL_NODES\nU\n*END STEP\n");
}

} // namespace livermark::exchange
