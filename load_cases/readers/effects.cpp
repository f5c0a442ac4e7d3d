#include "load_cases/readers/event_reader.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/support/input_error.hpp"
#include "load_cases/places/selector.hpp"

namespace livermark::load_cases {

namespace {

/// The depth to which a tool with a round end pushes a place. Its pressure vanishes at the rim, and the force on a tool
/// that is pushed in hardly changes when the rim moves, so that it matters little where the facets of a mesh end. A
/// flat tool has a pressure without bound at its rim, which every mesh resolves in another way. (Hertz's contact; K. L.
/// Johnson, Contact Mechanics, 1985, equations 3.39 and 3.41)
///
/// (N) parts of the depth of the middle to which the nodes of a place are pushed: the function that is linear on its
/// facets and nearest to 1 - (r/a)^2 / 2, and not below 0, in the mean square over their area. Values at the nodes
/// alone would make the place too shallow between them, the more so the coarser the mesh is. 1 at all other nodes.
std::vector<double> sinking(const core::RoundLoad &tool, const core::TetraMesh &mesh, const std::vector<int> &facets) {
    const auto nodes = nodes_of(facets, mesh);
    const auto num_nodes = std::ssize(nodes);
    Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(num_nodes, num_nodes);
    Eigen::VectorXd moment = Eigen::VectorXd::Zero(num_nodes);
    for (const int f : facets) {
        std::array<Eigen::Index, 3> place{};
        std::ranges::transform(mesh.boundary_triangles[f], place.begin(),
                               [&](int node) { return std::ranges::lower_bound(nodes, node) - nodes.begin(); });
        const double area = area_vector(mesh, f).norm();
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t l = 0; l < 3; ++l)
                mass(place[k], place[l]) += area / (k == l ? 6.0 : 12.0);
        const auto corners = core::corners_of(mesh, f);
        core::visit_triangle_parts([&](const core::Vector3 &at) {
            const core::Vector3 point = core::point_at(corners, at);
            const double ratio = (point - tool.middle).norm() / tool.radius;
            const double depth = std::max(0.0, 1.0 - 0.5 * ratio * ratio);
            for (std::size_t k = 0; k < 3; ++k)
                moment[place[k]] += area / core::num_triangle_parts * depth * at[static_cast<Eigen::Index>(k)];
        });
    }
    const Eigen::VectorXd nearest = mass.llt().solve(moment);
    std::vector<double> factor(mesh.points.size(), 1.0);
    for (Eigen::Index k = 0; k < num_nodes; ++k)
        factor[nodes[k]] = std::max(0.0, nearest[k]);
    return factor;
}

/// The same on every facet, or what a round tool makes of it.
Effect prescribed(const core::Vector3 &value, const Selection &selection, const core::TetraMesh &mesh) {
    Effect effect{core::ConditionKind::displacement, [=](int) { return value; }};
    if (selection.tool)
        effect.node_factor = sinking(*selection.tool, mesh, selection.facets);
    return effect;
}

Effect read_displacement(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    const auto value = support::required_vector(table, "displacement", true);
    if (value.array().isNaN().all())
        support::refuse(table, "a displacement that is free in every direction constrains nothing; give a number");
    return prescribed(value, selection, mesh);
}

Effect read_push(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    return prescribed(-support::required_number(table, "push") * pressed_normal(selection, mesh), selection, mesh);
}

Effect read_traction(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    const auto value = support::required_vector(table, "traction");
    return {core::ConditionKind::traction,
            [=, share = load_shares(selection, mesh)](int facet) { return core::Vector3(share[facet] * value); }};
}

core::Vector3 unit_normal(const core::TetraMesh &mesh, int facet) {
    return area_vector(mesh, facet).normalized();
}

/// Part of a traction along the surface, times the share of the load on a facet.
auto along_surface(const Selection &selection, const core::TetraMesh &mesh) {
    return [&mesh, share = load_shares(selection, mesh)](int facet, const core::Vector3 &value) {
        const core::Vector3 normal = unit_normal(mesh, facet);
        return core::Vector3(share[facet] * (value - value.dot(normal) * normal));
    };
}

Effect read_tangential_traction(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    const core::Vector3 value = support::required_vector(table, "tangential_traction");
    return {core::ConditionKind::traction,
            [value, along = along_surface(selection, mesh)](int facet) { return along(facet, value); }};
}

/// The same traction on the whole place, by the shares of its load.
Effect with_resultant(const core::Vector3 &force, const Selection &selection, const core::TetraMesh &mesh) {
    auto share = load_shares(selection, mesh);
    double area = 0.0;
    for (const int f : selection.facets)
        area += share[f] * area_vector(mesh, f).norm();
    return {core::ConditionKind::traction,
            [=, share = std::move(share)](int facet) { return core::Vector3(share[facet] / area * force); }};
}

Effect read_force(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    return with_resultant(support::required_vector(table, "force"), selection, mesh);
}

/// @param direction  of length 1
Effect pressing_to(double depth, const core::Vector3 &direction, const toml::node &place, const Selection &selection,
                   const core::TetraMesh &mesh) {
    if (depth == 0.0)
        support::refuse(place, "a place that presses by 0 m presses nothing; give a depth");
    auto effect = with_resultant(direction, selection, mesh);
    effect.kind = core::ConditionKind::press;
    effect.press_depth = depth;
    return effect;
}

Effect read_press(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    return pressing_to(support::required_number(table, "press"), -pressed_normal(selection, mesh), *table.get("press"),
                       selection, mesh);
}

Effect read_press_along(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    const auto way = support::required_vector(table, "press_along");
    return pressing_to(way.norm(), way.normalized(), *table.get("press_along"), selection, mesh);
}

Effect read_tangential_force(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    const core::Vector3 force = support::required_vector(table, "tangential_force");
    if (!(force.norm() > 0.0))
        support::refuse(*table.get("tangential_force"),
                        "the 'tangential_force' is zero; give one that pulls somewhere");
    const core::Vector3 direction = force / force.norm();
    const auto along = along_surface(selection, mesh);
    double resultant = 0.0; // of a unit traction
    for (const int f : selection.facets)
        resultant += area_vector(mesh, f).norm() * direction.dot(along(f, direction));
    if (!(resultant > 0.0))
        throw NotOnBody(support::place_of(*table.get("tangential_force")),
                        fmt::format("no facet of '{}' lies along the force", selection.name),
                        "choose another place or direction");
    return {core::ConditionKind::traction, [=](int facet) { return along(facet, force / resultant); }};
}

Effect pressing(double pressure, const Selection &selection, const core::TetraMesh &mesh) {
    return {core::ConditionKind::traction, [=, &mesh, share = load_shares(selection, mesh)](int facet) {
                return core::Vector3(share[facet] * (-pressure * unit_normal(mesh, facet)));
            }};
}

Effect read_pressure(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    return pressing(support::required_number(table, "pressure"), selection, mesh);
}

Effect read_follower_pressure(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    auto effect = pressing(support::required_number(table, "follower_pressure"), selection, mesh);
    effect.kind = core::ConditionKind::pressure;
    return effect;
}

/// Tractions c x r about the middle, with sum A r x (c x r) the torque.
Effect read_torque(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    const auto torque = support::required_vector(table, "torque");
    if (selection.tool)
        support::refuse(*table.get("torque"), "a round tool takes no torque; let its profile be \"flat\"");
    const core::Vector3 middle = middle_of(selection.facets, mesh);
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
    for (const int f : selection.facets) {
        const core::Vector3 r = facet_centroid(mesh, f) - middle;
        inertia += area_vector(mesh, f).norm() * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(inertia);
    if (!(axes.eigenvalues()[0] > 1e-9 * axes.eigenvalues()[2]))
        throw NotOnBody(support::place_of(*table.get("torque")),
                        fmt::format("the facets of '{}' stand in one line, which takes no torque", selection.name),
                        "choose a larger place");
    const core::Vector3 c =
        axes.eigenvectors() * (axes.eigenvectors().transpose() * torque).cwiseQuotient(axes.eigenvalues());
    return {core::ConditionKind::traction,
            [=, &mesh](int facet) { return core::Vector3(c.cross(facet_centroid(mesh, facet) - middle)); }};
}

struct EffectReader {
    std::string_view key;
    Effect (*read)(const toml::table &, const Selection &, const core::TetraMesh &);
    bool has_vector = false;
    bool is_length = false;
};

std::vector<std::string_view> keys_where(std::span<const EffectReader> readers, bool EffectReader::*is_wanted) {
    std::vector<std::string_view> keys;
    for (const auto &reader : readers)
        if (reader.*is_wanted)
            keys.push_back(reader.key);
    return keys;
}

constexpr std::array<EffectReader, 11> effect_readers{{{"displacement", read_displacement, true, true},
                                                       {"push", read_push, false, true},
                                                       {"press", read_press, false, true},
                                                       {"press_along", read_press_along, true, true},
                                                       {"traction", read_traction, true},
                                                       {"tangential_traction", read_tangential_traction, true},
                                                       {"force", read_force, true},
                                                       {"tangential_force", read_tangential_force, true},
                                                       {"pressure", read_pressure},
                                                       {"follower_pressure", read_follower_pressure},
                                                       {"torque", read_torque, true}}};

} // namespace

std::span<const std::string_view> effect_keys() {
    static const auto keys = [] {
        std::array<std::string_view, effect_readers.size()> all;
        std::ranges::transform(effect_readers, all.begin(), &EffectReader::key);
        return all;
    }();
    return keys;
}

const Quantities &effect_quantities() {
    static const Quantities quantities{.lengths = keys_where(effect_readers, &EffectReader::is_length),
                                       .directions = keys_where(effect_readers, &EffectReader::has_vector),
                                       .has_place = true};
    return quantities;
}

namespace {

/// @param table  of the condition; the effect uses the mesh later on
/// @throws support::InputError unless it has one of the keys, with a value that makes sense
Effect read_effect(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    const auto is_given = [&](const EffectReader &reader) { return table.contains(reader.key); };
    if (std::ranges::count_if(effect_readers, is_given) != 1)
        support::refuse(table, "a condition is either a 'displacement', a 'push', a 'press', a 'press_along', a "
                               "'traction', a 'tangential_traction', a 'force', a 'tangential_force', a 'pressure', a "
                               "'follower_pressure' or a 'torque'; give one of them");
    auto effect = std::ranges::find_if(effect_readers, is_given)->read(table, selection, mesh);
    if (effect.kind != core::ConditionKind::displacement)
        effect.round = selection.tool;
    return effect;
}

using core::Vector3;

/// Part of its area that a place may give up and still be that place.
constexpr double most_to_lose = 0.25;
constexpr double rounding_of_areas = 1e-9;

/// Obstacle to a place: one above it that has its facets or moves its nodes.
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
