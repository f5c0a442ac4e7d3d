#include <array>
#include <fmt/format.h>
#include <string>
#include <string_view>

#include "core/support/input_error.hpp"
#include "msm/springs/spring_network.hpp"
#include "studies/models/mass_spring_model.hpp"

namespace livermark::models::families {

namespace {

using livermark::msm::SpringCurve;
using livermark::msm::SpringLaw;

core::Model named(std::string name, const SpringLaw &law, const SpringCurve &curve, const MakeMassSprings &make,
                  const ModelOptions &options) {
    auto model = mass_spring_model(std::move(name), fmt::format("{}; {}", law.summary, curve.summary),
                                   fmt::format("{}; {}", law.source, curve.source), make, options);
    model.only_when_named = true;
    return model;
}

/// Springs alone, under the name <law>_<curve>.
core::Model alone(const SpringLaw &law, const SpringCurve &curve, const ModelOptions &options) {
    return named(
        fmt::format("{}_{}", law.name, curve.name), law, curve,
        [law, curve](const core::Body &body) -> livermark::msm::MassSprings {
            const auto springs = livermark::msm::spring_network(body, law);
            return {springs, {springs.node_mass, {livermark::msm::spring_term(springs, curve.curve)}}};
        },
        options);
}

/// Beside the volume around nodes, under the name <law>_<curve>_nodal_volume.
core::Model with_volume(const SpringLaw &law, const SpringCurve &curve, const ModelOptions &options) {
    return named(
        fmt::format("{}_{}_nodal_volume", law.name, curve.name), law, curve,
        [law, curve](const core::Body &body) {
            return livermark::msm::springs_with_volume(body, livermark::msm::springs_beside_volume(body, law),
                                                       livermark::msm::find_volume_term("nodal_volume"), curve.curve);
        },
        options);
}

constexpr std::array<std::string_view, 2> laws{"lloyd", "patch"};

} // namespace

/// Springs whose force is no line, with every curve. They join a run only when they are named: at small strains they
/// are the springs with Hooke's.
ModelFamily spring_curves() {
    return {.name = {}, .models = [](const ModelOptions &options) {
                std::vector<core::Model> models;
                for (const auto &law : laws)
                    for (const auto &curve : livermark::msm::all_spring_curves()) {
                        const auto &known =
                            support::find_named(livermark::msm::all_spring_laws(), std::string(law), "spring law");
                        models.push_back(alone(known, curve, options));
                        models.push_back(with_volume(known, curve, options));
                    }
                return models;
            }};
}

} // namespace livermark::models::families
