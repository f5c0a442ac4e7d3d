#include "load_cases/places/place_apart.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <vector>

#include "load_cases/places/facets.hpp"

namespace livermark::load_cases {

namespace {

using core::Vector3;

/// Part of its area that a place may give up and still be that place.
constexpr double most_to_lose = 0.25;
constexpr double rounding_of_areas = 1e-9;

/// What a place is in the way of.
struct Obstacle {
    std::string name;              ///< of the place above, in quotes
    std::optional<Vector3> node{}; ///< where two displacements meet; none where facets are in both places
};

/// The place above that prescribes the displacement of each node, and what it prescribes.
struct PrescribedNodes {
    std::vector<Vector3> value;  ///< (N) NaN where nothing is prescribed
    std::vector<int> constraint; ///< (N) -1 where nothing is prescribed
};

PrescribedNodes prescribed_nodes(const core::TetraMesh &mesh, const core::LoadCase &load_case) {
    PrescribedNodes nodes{
        std::vector<Vector3>(mesh.points.size(), Vector3::Constant(std::numeric_limits<double>::quiet_NaN())),
        std::vector<int>(mesh.points.size(), -1)};
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.is_constrained(f))
            for (const int node : mesh.boundary_triangles[f]) {
                nodes.constraint[node] = load_case.constraint_on(f);
                for (int c = 0; c < 3; ++c)
                    if (!std::isnan(load_case.value[f][c]))
                        nodes.value[node][c] = load_case.value[f][c];
            }
    return nodes;
}

/// Whether a node cannot have both. It has one factor for all its components.
bool is_contradicted(const Vector3 &prescribed, double prescribed_factor, const Vector3 &wanted, double wanted_factor) {
    const auto moves = [](double component) { return component < 0.0 || component > 0.0; };
    if (prescribed_factor != wanted_factor && std::ranges::any_of(prescribed, moves))
        return true;
    for (int c = 0; c < 3; ++c)
        if (!std::isnan(prescribed[c]) && !std::isnan(wanted[c]) && prescribed[c] != wanted[c])
            return true;
    return false;
}

/// Takes the facets that have a condition already from a place.
void yield_taken(Selection &selection, const core::LoadCase &above, std::optional<Obstacle> &first) {
    std::erase_if(selection.facets, [&](int f) {
        if (above.is_free(f))
            return false;
        if (!first)
            first = Obstacle{fmt::format("'{}'", above.on(f)->place)};
        return true;
    });
}

/// Takes the facets with a node that moves otherwise from a place.
/// @return whether there were any
bool yield_contradicted(Selection &selection, const Effect &effect, const core::TetraMesh &mesh,
                        const PrescribedNodes &nodes, const core::LoadCase &above, std::optional<Obstacle> &first) {
    if (effect.kind != core::ConditionKind::displacement)
        return false;
    return std::erase_if(selection.facets, [&](int f) {
               const Vector3 wanted = effect.value(f);
               const auto &corners = mesh.boundary_triangles[f];
               const auto node = std::ranges::find_if(corners, [&](int corner) {
                   const double factor = effect.node_factor.empty() ? 1.0 : effect.node_factor[corner];
                   return is_contradicted(nodes.value[corner], above.factor_at(corner), wanted, factor);
               });
               if (node == corners.end())
                   return false;
               if (!first)
                   first = Obstacle{fmt::format("'{}'", above.constraint_names()[nodes.constraint[*node]]),
                                    mesh.points[*node]};
               return true;
           }) > 0;
}

std::string reason_of(const std::string &name, const Obstacle &obstacle, double part_left) {
    const auto kept = fmt::format("it keeps {:.0f} % of its area and needs {:.0f} %", 100.0 * part_left,
                                  100.0 * (1.0 - most_to_lose));
    if (!obstacle.node)
        return fmt::format("'{}' overlaps {}, and without the facets that are in both {}", name, obstacle.name, kept);
    return fmt::format("'{}' moves nodes that {} moves differently, such as the node at ({:g}, {:g}, {:g}) m, and "
                       "without the facets there {}",
                       name, obstacle.name, obstacle.node->x(), obstacle.node->y(), obstacle.node->z(), kept);
}

} // namespace

PlacedCondition place_apart(const toml::table &table, Selection selection, const core::TetraMesh &mesh,
                            const core::LoadCase &above) {
    const auto nodes = prescribed_nodes(mesh, above);
    const auto num_facets = selection.facets.size();
    const double area = area_of(selection.facets, mesh);
    std::optional<Obstacle> obstacle;
    const auto lost_area = [&] {
        if (selection.facets.size() == num_facets)
            return 0.0;
        const double left = area_of(selection.facets, mesh) / area;
        if (1.0 - left > most_to_lose + rounding_of_areas)
            throw NotOnBody(support::place_of(table), reason_of(selection.name, *obstacle, left),
                            "choose places that neither overlap nor touch");
        return 1.0 - left;
    };
    yield_taken(selection, above, obstacle);
    double lost = lost_area();
    auto effect = read_effect(table, selection, mesh);
    while (yield_contradicted(selection, effect, mesh, nodes, above, obstacle)) {
        lost = lost_area();
        effect = read_effect(table, selection, mesh); // what is left may face another way
    }
    return {std::move(selection), std::move(effect), lost};
}

} // namespace livermark::load_cases
