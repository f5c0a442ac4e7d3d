#include <algorithm>
#include <fmt/format.h>

#include "load_cases/places/selector.hpp"

namespace livermark::load_cases::selectors {

namespace {

using core::Vector3;

double distance_to(const std::vector<Vector3> &points, const Vector3 &point) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto &other : points)
        nearest = std::min(nearest, (other - point).norm());
    return nearest;
}

double positive(const toml::table &table, const char *key) {
    const double value = support::required_number(table, key);
    if (!(value > 0.0))
        support::refuse(table, "'{}' is {} m; it has to be positive", key, value);
    return value;
}

Selection select(const toml::table &condition, const core::TetraMesh &mesh, const core::LoadCase &) {
    const auto &edge = support::required_table(condition, "edge");
    support::refuse_unknown_keys(edge, {"between", "width", "length"});
    const auto names = support::required_strings(edge, "between");
    if (names.size() != 2 || names[0] == names[1])
        support::refuse(*edge.get("between"), "an edge is 'between' two patches; name two");
    const double width = positive(edge, "width");
    const double length = positive(edge, "length");
    refuse_beyond_body(edge, "width", width, mesh);
    auto facets = facets_of_patch(names[0], *edge.get("between"), mesh);
    const auto others = facets_of_patch(names[1], *edge.get("between"), mesh);
    std::vector<int> shared;
    std::ranges::set_intersection(nodes_of(facets, mesh), nodes_of(others, mesh), std::back_inserter(shared));

    Selection selection{fmt::format("edge between {} and {}", names[0], names[1]), {}};
    if (shared.empty())
        return selection;
    std::vector<Vector3> line;
    Vector3 mean = Vector3::Zero();
    for (const int node : shared) {
        line.push_back(mesh.points[node]);
        mean += mesh.points[node] / static_cast<double>(shared.size());
    }
    const Vector3 middle =
        *std::ranges::min_element(line, {}, [&](const Vector3 &point) { return (point - mean).squaredNorm(); });
    facets.insert(facets.end(), others.begin(), others.end());
    std::ranges::sort(facets);
    std::ranges::copy_if(facets, std::back_inserter(selection.facets), [&](int f) {
        const Vector3 centroid = facet_centroid(mesh, f);
        return distance_to(line, centroid) <= width && (centroid - middle).norm() <= 0.5 * length;
    });
    return selection;
}

} // namespace

/// edge = { between = ["anterior", "inferior"], width = 0.01, length = 0.06 }: where two patches meet. The facets of
/// both whose centroid is within the width of a node that they share, and within half the length of the middle one of
/// these nodes [m].
Selector edge() {
    return {.name = {}, .select = select};
}

} // namespace livermark::load_cases::selectors
