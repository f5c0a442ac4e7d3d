#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <iterator>
#include <vector>

#include "load_cases/facets.hpp"
#include "load_cases/selector.hpp"

namespace livermark::load_cases::selectors {

namespace {

using core::Vector3;

std::vector<int> nodes_of(const std::vector<int> &facets, const core::TetraMesh &mesh) {
    std::vector<int> nodes;
    for (const int f : facets)
        nodes.insert(nodes.end(), mesh.boundary_triangles[f].begin(), mesh.boundary_triangles[f].end());
    std::ranges::sort(nodes);
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    return nodes;
}

using Segment = std::array<Vector3, 2>;

/// Sides of triangles whose ends are both in two patches.
std::vector<Segment> line_between(const std::vector<int> &facets, const std::vector<int> &shared,
                                  const core::TetraMesh &mesh) {
    std::vector<Segment> line;
    const auto is_shared = [&](int node) { return std::ranges::binary_search(shared, node); };
    for (const int f : facets)
        for (std::size_t k = 0; k < 3; ++k) {
            const int a = mesh.boundary_triangles[f][k], b = mesh.boundary_triangles[f][(k + 1) % 3];
            if (is_shared(a) && is_shared(b))
                line.push_back({mesh.points[a], mesh.points[b]});
        }
    return line;
}

Vector3 nearest_point(const std::vector<Segment> &line, const Vector3 &point) {
    Vector3 nearest = line.front()[0];
    for (const auto &[a, b] : line)
        if (const Vector3 candidate = nearest_of_segment(a, b, point);
            (candidate - point).squaredNorm() < (nearest - point).squaredNorm())
            nearest = candidate;
    return nearest;
}

Vector3 centroid(const std::vector<Segment> &line) {
    Vector3 moment = Vector3::Zero();
    double length = 0.0;
    for (const auto &[a, b] : line) {
        moment += 0.5 * (b - a).norm() * (a + b);
        length += (b - a).norm();
    }
    return moment / length;
}

double positive(const toml::table &table, const char *key) {
    const double value = support::required_number(table, key);
    if (!(value > 0.0))
        throw support::InputError(
            fmt::format("{}: '{}' is {} m; it has to be positive", support::place_of(table), key, value));
    return value;
}

Selection select(const toml::table &condition, const core::TetraMesh &mesh, std::span<const core::FacetCondition>) {
    const auto &edge = support::required_table(condition, "edge");
    support::refuse_unknown_keys(edge, {"between", "width", "length"});
    const auto names = support::required_strings(edge, "between");
    if (names.size() != 2 || names[0] == names[1])
        throw support::InputError(
            fmt::format("{}: an edge is 'between' two patches; name two", support::place_of(*edge.get("between"))));
    const double width = positive(edge, "width");
    const double length = positive(edge, "length");
    auto facets = facets_of_patch(names[0], *edge.get("between"), mesh);
    const auto others = facets_of_patch(names[1], *edge.get("between"), mesh);
    std::vector<int> shared;
    std::ranges::set_intersection(nodes_of(facets, mesh), nodes_of(others, mesh), std::back_inserter(shared));
    const auto line = line_between(facets, shared, mesh);

    Selection selection{fmt::format("edge between {} and {}", names[0], names[1]), {}};
    if (line.empty())
        return selection;
    const Vector3 middle = nearest_point(line, centroid(line));
    facets.insert(facets.end(), others.begin(), others.end());
    std::ranges::sort(facets);
    std::ranges::copy_if(facets, std::back_inserter(selection.facets), [&](int f) {
        const Vector3 point = facet_centroid(mesh, f);
        return (point - nearest_point(line, point)).norm() <= width && (point - middle).norm() <= 0.5 * length;
    });
    return selection;
}

} // namespace

/// edge = { between = ["anterior", "inferior"], width = 0.01, length = 0.06 }: where two patches meet. The facets of
/// both whose centroid is within the width of the line between them, and within half the length of the middle of that
/// line [m].
Selector edge() {
    return {.name = {}, .select = select};
}

} // namespace livermark::load_cases::selectors
