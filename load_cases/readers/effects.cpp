#include "load_cases/readers/effects.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <utility>
#include <vector>

#include "load_cases/places/facets.hpp"
#include "support/input_error.hpp"

namespace livermark::load_cases {

namespace {

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
        throw support::InputError(
            fmt::format("{}: a displacement that is free in every direction constrains nothing; give a number",
                        support::place_of(table)));
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

/// What of a traction goes along the surface, times the share of the load on a facet.
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
        throw support::InputError(
            fmt::format("{}: a place that presses by 0 m presses nothing; give a depth", support::place_of(place)));
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
        throw support::InputError(fmt::format("{}: the 'tangential_force' is zero; give one that pulls somewhere",
                                              support::place_of(*table.get("tangential_force"))));
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
        throw support::InputError(fmt::format("{}: a round tool takes no torque; let its profile be \"flat\"",
                                              support::place_of(*table.get("torque"))));
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

Effect read_effect(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    const auto is_given = [&](const EffectReader &reader) { return table.contains(reader.key); };
    if (std::ranges::count_if(effect_readers, is_given) != 1)
        throw support::InputError(fmt::format(
            "{}: a condition is either a 'displacement', a 'push', a 'press', a 'press_along', a 'traction', a "
            "'tangential_traction', a 'force', a 'tangential_force', a 'pressure', a 'follower_pressure' or a "
            "'torque'; give one of them",
            support::place_of(table)));
    auto effect = std::ranges::find_if(effect_readers, is_given)->read(table, selection, mesh);
    if (effect.kind != core::ConditionKind::displacement)
        effect.round = selection.tool;
    return effect;
}

} // namespace livermark::load_cases
