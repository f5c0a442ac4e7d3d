#include "load_cases/effects.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <vector>

#include "load_cases/facets.hpp"
#include "support/input_error.hpp"

namespace livermark::load_cases {

namespace {

/// The same on every facet.
Effect uniform(core::FacetCondition condition, const core::Vector3 &value) {
    return {condition, [=](int) { return value; }};
}

Effect read_displacement(const toml::table &table, const Selection &, const core::TetraMesh &) {
    const auto value = support::required_vector(table, "displacement", true);
    if (value.array().isNaN().all())
        throw support::InputError(
            fmt::format("{}: a displacement that is free in every direction constrains nothing; give a number",
                        support::place_of(table)));
    return uniform(core::FacetCondition::prescribed_displacement, value);
}

Effect read_push(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    return uniform(core::FacetCondition::prescribed_displacement,
                   -support::required_number(table, "push") * mean_normal(selection.facets, mesh));
}

Effect read_traction(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    return uniform(core::FacetCondition::traction,
                   area_ratio(selection, mesh) * support::required_vector(table, "traction"));
}

core::Vector3 unit_normal(const core::TetraMesh &mesh, int facet) {
    return area_vector(mesh, facet).normalized();
}

Effect read_tangential_traction(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    const core::Vector3 value = area_ratio(selection, mesh) * support::required_vector(table, "tangential_traction");
    return {core::FacetCondition::traction, [=, &mesh](int facet) {
                const core::Vector3 normal = unit_normal(mesh, facet);
                return core::Vector3(value - value.dot(normal) * normal);
            }};
}

Effect read_pressure(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    const double pressure = support::required_number(table, "pressure");
    return {core::FacetCondition::traction, [=, &mesh, ratio = area_ratio(selection, mesh)](int facet) {
                return core::Vector3(ratio * (-pressure * unit_normal(mesh, facet)));
            }};
}

Effect read_follower_pressure(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    const double pressure = support::required_number(table, "follower_pressure");
    return {core::FacetCondition::traction,
            [=, &mesh, ratio = area_ratio(selection, mesh)](int facet) {
                return core::Vector3(ratio * (-pressure * unit_normal(mesh, facet)));
            },
            true};
}

/// Tractions c x r about the middle, with sum A r x (c x r) the torque.
Effect read_torque(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    const auto torque = support::required_vector(table, "torque");
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
    return {core::FacetCondition::traction,
            [=, &mesh](int facet) { return core::Vector3(c.cross(facet_centroid(mesh, facet) - middle)); }};
}

struct EffectReader {
    std::string_view key;
    Effect (*read)(const toml::table &, const Selection &, const core::TetraMesh &);
};

constexpr std::array<EffectReader, 7> effect_readers{{{"displacement", read_displacement},
                                                      {"push", read_push},
                                                      {"traction", read_traction},
                                                      {"tangential_traction", read_tangential_traction},
                                                      {"pressure", read_pressure},
                                                      {"follower_pressure", read_follower_pressure},
                                                      {"torque", read_torque}}};

} // namespace

std::span<const std::string_view> effect_keys() {
    static const auto keys = [] {
        std::vector<std::string_view> result;
        for (const auto &reader : effect_readers)
            result.push_back(reader.key);
        return result;
    }();
    return keys;
}

Effect read_effect(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh) {
    const auto is_given = [&](const EffectReader &reader) { return table.contains(reader.key); };
    if (std::ranges::count_if(effect_readers, is_given) != 1)
        throw support::InputError(
            fmt::format("{}: a condition is either a 'displacement', a 'push', a 'traction', a "
                        "'tangential_traction', a 'pressure', a 'follower_pressure' or a 'torque'; "
                        "give one of them",
                        support::place_of(table)));
    return std::ranges::find_if(effect_readers, is_given)->read(table, selection, mesh);
}

} // namespace livermark::load_cases
