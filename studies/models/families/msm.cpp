#include <array>
#include <fmt/format.h>
#include <string>
#include <string_view>

#include "core/support/input_error.hpp"
#include "msm/springs/springs.hpp"
#include "studies/models/model_table.hpp"

namespace livermark::models::families {

namespace {

using livermark::msm::ForceCurve;
using livermark::msm::hooke;
using livermark::msm::MassSprings;
using livermark::msm::SpringLaw;
using livermark::msm::VolumeTerm;

MakeMassSprings springs_alone(const SpringLaw &law, const ForceCurve &curve = hooke) {
    return [law, curve](const core::Body &body) -> MassSprings {
        const auto springs = livermark::msm::spring_network(body, law);
        return {springs, {springs.node_mass, {livermark::msm::spring_term(springs, curve)}}};
    };
}

MakeMassSprings springs_beside(const VolumeTerm &term, const SpringLaw &law, const ForceCurve &curve = hooke) {
    return [law, term, curve](const core::Body &body) {
        return livermark::msm::springs_with_volume(body, livermark::msm::springs_beside_volume(body, law), term, curve);
    };
}

const SpringLaw &law_named(std::string_view name) {
    return support::find_named(livermark::msm::all_spring_laws(), std::string(name), "spring law");
}

core::Model with_volume(std::string name, const SpringLaw &law, std::string_view term_name,
                        const ModelOptions &options) {
    const auto &term = livermark::msm::find_volume_term(term_name);
    return mass_spring_model(std::move(name), fmt::format("{}, with {}", law.summary, term.summary),
                             fmt::format("{}; {}", law.source, term.source), springs_beside(term, law), options);
}

/// Pairs of a law and a volume term. Not every pair is worth its time in a run over everything.
constexpr std::array<std::array<std::string_view, 2>, 4> pairs{{
    {"lloyd", "nodal_volume"},
    {"patch", "nodal_volume"},
    {"van_gelder", "nodal_volume"},
    {"van_gelder", "tetrahedral_volume"},
}};

/// Springs whose stiffnesses were fitted to solutions of finite elements on this very mesh, and the nodal volume that
/// they were fitted beside.
core::Model fitted(const std::shared_ptr<const core::CalibratedSprings> &calibration, const ModelOptions &options) {
    const auto &term = livermark::msm::find_volume_term("nodal_volume");
    auto model = mass_spring_model(
        "calibrated_nodal_volume", fmt::format("springs fitted to finite elements on this mesh, with {}", term.summary),
        fmt::format("`python3 -m livermark.calibration`; {}", term.source),
        [calibration, term](const core::Body &body) {
            core::check_fit(*calibration, body);
            return livermark::msm::springs_with_volume(body,
                                                       {.node_mass = livermark::msm::lumped_masses(body),
                                                        .edges = calibration->edges,
                                                        .stiffness = calibration->stiffness,
                                                        .rest_length = calibration->rest_length},
                                                       term);
        },
        options);
    model.check = [calibration, check = model.check](const core::Problem &problem) {
        core::check_fit(*calibration, *problem.body);
        check(problem);
    };
    return model;
}

/// Laws of which all curves are models.
constexpr std::array<std::string_view, 2> laws_with_curves{"lloyd", "patch"};

/// Models under the names <law>_<curve> and <law>_<curve>_nodal_volume, when they are named alone: at small strains
/// they are the springs with Hooke's curve.
void add_curves(std::vector<core::Model> &models, const ModelOptions &options) {
    const auto &volume = livermark::msm::find_volume_term("nodal_volume");
    for (const auto name : laws_with_curves)
        for (const auto &curve : livermark::msm::all_spring_curves()) {
            const auto &law = law_named(name);
            const auto add = [&](const char *ending, const MakeMassSprings &make) {
                models.push_back(mass_spring_model(fmt::format("{}_{}{}", law.name, curve.name, ending),
                                                   fmt::format("{}; {}", law.summary, curve.summary),
                                                   fmt::format("{}; {}", law.source, curve.source), make, options));
                models.back().only_when_named = true;
            };
            add("", springs_alone(law, curve.curve));
            add("_nodal_volume", springs_beside(volume, law, curve.curve));
        }
}

std::vector<core::Model> uncoupled_springs(const ModelOptions &options) {
    std::vector<core::Model> models;
    for (const auto &law : livermark::msm::all_spring_laws())
        models.push_back(mass_spring_model(law.name, law.summary, law.source, springs_alone(law), options));
    for (const auto &[law, term] : pairs)
        models.push_back(with_volume(fmt::format("{}_{}", law, term), law_named(law), term, options));
    for (const double weight : options.sweep_of("patch_nodal_volume.w"))
        models.push_back(with_volume(swept_name("patch_nodal_volume.w", weight), livermark::msm::patch_with(weight),
                                     "nodal_volume", options));
    if (options.calibration)
        models.push_back(fitted(options.calibration, options));
    add_curves(models, options);
    return models;
}

} // namespace

/// Springs on the edges of the mesh, barycentric masses: each spring law alone, under its name, and some with a volume
/// term, under the name <law>_<volume term>, or with a force curve; patch with other weights where the options say so.
ModelFamily msm() {
    return {.name = {}, .models = uncoupled_springs};
}

} // namespace livermark::models::families
