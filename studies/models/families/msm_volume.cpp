#include <array>
#include <fmt/format.h>
#include <string>
#include <string_view>

#include "core/support/input_error.hpp"
#include "msm/springs/spring_network.hpp"
#include "studies/models/mass_spring_model.hpp"

namespace livermark::models::families {

namespace {

core::Model model(std::string name, const msm::SpringLaw &law, const msm::VolumeTerm &term,
                  const ModelOptions &options) {
    return mass_spring_model(
        std::move(name), fmt::format("{}, with {}", law.summary, term.summary),
        fmt::format("{}; {}", law.source, term.source),
        [law, term](const core::Body &body) {
            return livermark::msm::springs_with_volume(body, livermark::msm::springs_beside_volume(body, law), term);
        },
        options);
}

/// Not every pair is worth its time in a run over everything.
constexpr std::array<std::array<std::string_view, 2>, 4> pairs{{
    {"lloyd", "nodal_volume"},
    {"patch", "nodal_volume"},
    {"van_gelder", "nodal_volume"},
    {"van_gelder", "tetrahedral_volume"},
}};

} // namespace

/// Springs and a volume term, under the name <law>_<volume term>, and patch with other weights where the options say
/// so.
ModelFamily msm_volume() {
    return {.name = {}, .models = [](const ModelOptions &options) {
                std::vector<core::Model> models;
                for (const auto &[law, term] : pairs)
                    models.push_back(
                        model(fmt::format("{}_{}", law, term),
                              support::find_named(livermark::msm::all_spring_laws(), std::string(law), "spring law"),
                              livermark::msm::find_volume_term(term), options));
                for (const double weight : options.sweep_of("patch_nodal_volume.w"))
                    models.push_back(model(swept_name("patch_nodal_volume.w", weight),
                                           livermark::msm::patch_with(weight),
                                           livermark::msm::find_volume_term("nodal_volume"), options));
                return models;
            }};
}

} // namespace livermark::models::families
