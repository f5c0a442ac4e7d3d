#include "studies/sensitivity/soft_support.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <memory>
#include <set>

#include "studies/sensitivity/patient.hpp"
#include "support/input_error.hpp"

namespace livermark::studies {

namespace {

using core::Vector3;

constexpr double thickness_in_edges = 0.05;
constexpr double layer_poisson_ratio = 0.25;
/// Modulus of a layer that cannot widen, over Young's modulus: (1 - nu) / ((1 + nu)(1 - 2 nu)).
constexpr double confined_modulus =
    (1.0 - layer_poisson_ratio) / ((1.0 + layer_poisson_ratio) * (1.0 - 2.0 * layer_poisson_ratio));

std::array<int, 3> sorted_corners(std::array<int, 3> corners) {
    std::ranges::sort(corners);
    return corners;
}

double held_edge_length(const core::TetraMesh &mesh, const std::vector<int> &facets) {
    double sum = 0.0;
    for (const int facet : facets) {
        const auto [a, b, c] = core::corners_of(mesh, facet);
        sum += (a - b).norm() + (b - c).norm() + (c - a).norm();
    }
    return sum / (3.0 * static_cast<double>(facets.size()));
}

/// The node of the outer side over each node of the facets, in ascending order of both; appended to the mesh.
std::map<int, int> add_outer_nodes(core::TetraMesh &mesh, const std::vector<int> &facets, double thickness) {
    std::map<int, Vector3> normals;
    for (const int facet : facets)
        for (const int node : mesh.boundary_triangles[facet])
            normals.try_emplace(node, Vector3::Zero()).first->second += core::area_vector(mesh, facet);
    std::map<int, int> outer;
    for (const auto &[node, normal] : normals) {
        outer[node] = mesh.num_nodes();
        mesh.points.emplace_back(mesh.points[node] + thickness * normal.normalized());
    }
    return outer;
}

/// A prism over a facet in three tetrahedra that fit those of its neighbours: diagonals start at the lower number.
/// (J. Dompierre et al. 1999, How to subdivide pyramids, prisms and hexahedra into tetrahedra, CERCA R99-78)
std::array<std::array<int, 4>, 3> prism(std::array<int, 3> corners, const std::map<int, int> &outer) {
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    const auto [a, b, c] = corners;
    const int over_a = outer.at(a), over_b = outer.at(b), over_c = outer.at(c);
    if (b < c)
        return {{{a, b, c, over_c}, {a, b, over_c, over_b}, {a, over_b, over_c, over_a}}};
    return {{{a, b, c, over_b}, {a, over_b, c, over_c}, {a, over_b, over_c, over_a}}};
}

/// The free facets around the layer, with the patch of the held ones.
void add_rim(core::TetraMesh &mesh, int num_nodes, int patch) {
    std::set<std::array<int, 3>> known;
    for (const auto &corners : mesh.boundary_triangles)
        known.insert(sorted_corners(corners));
    for (const auto &corners : core::outer_faces(mesh.tetrahedra))
        if (std::ranges::any_of(corners, [&](int node) { return node >= num_nodes; }) &&
            !known.contains(sorted_corners(corners))) {
            mesh.boundary_triangles.push_back(corners);
            mesh.boundary_patch.push_back(patch);
        }
}

template <class Value> void extend(std::vector<Value> &values, std::size_t size, const Value &with) {
    if (!values.empty())
        values.resize(size, with);
}

core::LoadCase on_layer(core::LoadCase load_case, const core::TetraMesh &mesh) {
    const auto num_facets = mesh.boundary_triangles.size(), num_nodes = mesh.points.size();
    load_case.condition_on.resize(num_facets, -1);
    load_case.value.resize(num_facets, Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
    extend(load_case.node_factor, num_nodes, 1.0);
    const Vector3 nowhere = Vector3::Zero();
    extend(load_case.node_shift, num_nodes, nowhere);
    return load_case;
}

} // namespace

core::Problem with_soft_support(const core::Problem &problem, double stiffness) {
    const auto held = held_facets(problem.load_case);
    auto body = std::make_shared<core::Body>(*problem.body);
    auto &mesh = body->mesh;
    const int num_nodes = mesh.num_nodes();
    const double thickness = thickness_in_edges * held_edge_length(mesh, held);
    const auto outer = add_outer_nodes(mesh, held, thickness);
    const auto region = static_cast<int>(mesh.region_names.size());
    mesh.region_names.emplace_back("support");
    body->materials.push_back({.density = body->materials.front().density,
                               .young_modulus = stiffness * thickness / confined_modulus,
                               .poisson_ratio = layer_poisson_ratio});
    for (const int facet : held) {
        auto &corners = mesh.boundary_triangles[facet];
        for (const auto &tetrahedron : prism(corners, outer)) {
            const auto &[a, b, c, d] = tetrahedron;
            if (!(core::signed_volume(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]) > 0.0))
                throw support::InputError(
                    fmt::format("{}: the surface that {} constrains folds back within {:.2g} mm, so no soft support "
                                "fits on it; mesh it more finely, or leave [support_stiffness] out of the ranges",
                                body->name, problem.load_case.name, 1e3 * thickness));
            mesh.tetrahedra.push_back(tetrahedron);
            mesh.region.push_back(region);
        }
        for (int &node : corners)
            node = outer.at(node);
    }
    add_rim(mesh, num_nodes, mesh.boundary_patch[held.front()]);
    return {body, on_layer(problem.load_case, mesh)};
}

} // namespace livermark::studies
