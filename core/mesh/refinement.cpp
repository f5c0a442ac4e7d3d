#include "core/mesh/refinement.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>

namespace livermark::core {

namespace {

/// A diagonal of the inner octahedron joins the middles of two opposite edges, and the other four middles go around it.
/// Numbers are places in tetrahedron_edges; each ring turns so that the tetrahedra (from, to, ring k, ring k + 1) have
/// the sign of the parent.
struct OctahedronCut {
    int from;
    int to;
    std::array<int, 4> ring;
};
constexpr std::array<OctahedronCut, 3> octahedron_cuts{
    {{0, 5, {1, 2, 4, 3}}, {1, 4, {0, 3, 5, 2}}, {2, 3, {0, 1, 5, 4}}}};

/// For each corner of a tetrahedron the edges to the other corners, in an order that keeps the sign.
constexpr std::array<std::array<int, 3>, 4> edges_at_corner{{{0, 1, 2}, {0, 4, 3}, {1, 3, 5}, {2, 5, 4}}};

template <class T> std::vector<T> repeated(const std::vector<T> &values, int times) {
    std::vector<T> result;
    result.reserve(values.size() * times);
    for (const auto &value : values)
        result.insert(result.end(), times, value);
    return result;
}

void cut_tetrahedron(const std::array<int, 4> &corners, const std::array<int, 6> &middles, TetraMesh &fine) {
    for (int corner = 0; corner < 4; ++corner) {
        const auto &[a, b, c] = edges_at_corner[corner];
        fine.tetrahedra.push_back({corners[corner], middles[a], middles[b], middles[c]});
    }
    const auto length = [&](const OctahedronCut &cut) {
        return (fine.points[middles[cut.from]] - fine.points[middles[cut.to]]).squaredNorm();
    };
    const auto &cut = *std::ranges::min_element(octahedron_cuts, {}, length);
    for (int k = 0; k < 4; ++k)
        fine.tetrahedra.push_back(
            {middles[cut.from], middles[cut.to], middles[cut.ring[k]], middles[cut.ring[(k + 1) % 4]]});
}

void cut_triangle(const std::array<int, 3> &corners, const EdgeTable &table, int num_coarse_nodes, TetraMesh &fine) {
    const auto middle = [&](int a, int b) {
        const std::array edge{std::min(a, b), std::max(a, b)};
        const auto found = std::ranges::lower_bound(table.edges, edge);
        if (found == table.edges.end() || *found != edge)
            throw std::invalid_argument(
                fmt::format("the edge of nodes {} and {} of a boundary triangle belongs to no tetrahedron", a, b));
        return num_coarse_nodes + static_cast<int>(found - table.edges.begin());
    };
    const auto &[a, b, c] = corners;
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    fine.boundary_triangles.insert(fine.boundary_triangles.end(),
                                   {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
}

} // namespace

Body refine(const Body &body) {
    const auto &coarse = body.mesh;
    const auto table = edge_table(coarse.tetrahedra);
    Body refined{.name = body.name, .mesh = {}, .materials = body.materials};
    auto &fine = refined.mesh;
    fine.points = coarse.points;
    fine.points.reserve(coarse.points.size() + table.edges.size());
    for (const auto &[a, b] : table.edges)
        fine.points.emplace_back(0.5 * (coarse.points[a] + coarse.points[b]));

    fine.tetrahedra.reserve(8 * coarse.tetrahedra.size());
    for (std::size_t t = 0; t < coarse.tetrahedra.size(); ++t) {
        auto middles = table.tetrahedron_edge[t];
        for (int &middle : middles)
            middle += coarse.num_nodes();
        cut_tetrahedron(coarse.tetrahedra[t], middles, fine);
    }
    fine.region = repeated(coarse.region, 8);
    fine.region_names = coarse.region_names;

    fine.boundary_triangles.reserve(4 * coarse.boundary_triangles.size());
    for (const auto &triangle : coarse.boundary_triangles)
        cut_triangle(triangle, table, coarse.num_nodes(), fine);
    fine.boundary_patch = repeated(coarse.boundary_patch, 4);
    fine.patch_names = coarse.patch_names;
    return refined;
}

LoadCase refine(const LoadCase &load_case, const TetraMesh &coarse) {
    auto refined = load_case;
    refined.condition_on = repeated(load_case.condition_on, 4);
    refined.value = repeated(load_case.value, 4);
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.round_load_on(f)) {
            const auto [a, b, c] = corners_of(coarse, f); // as cut_triangle() has them
            const Vector3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
            const std::array<Corners, 4> parts{{{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}};
            const auto share = shares_of_parts(load_case.round_load_on(f), parts);
            for (int k = 0; k < 4; ++k)
                refined.value[4 * f + k] *= share[k];
        }
    if (!load_case.node_factor.empty())
        for (const auto &[a, b] : edge_table(coarse.tetrahedra).edges)
            refined.node_factor.push_back(load_case.factor_between(a, b));
    if (!load_case.node_shift.empty())
        for (const auto &[a, b] : edge_table(coarse.tetrahedra).edges)
            refined.node_shift.emplace_back(0.5 * (load_case.node_shift[a] + load_case.node_shift[b]));
    return refined;
}

Problem refine(const Problem &problem) {
    return {std::make_shared<const Body>(refine(*problem.body)), refine(problem.load_case, problem.body->mesh)};
}

} // namespace livermark::core
