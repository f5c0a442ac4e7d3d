#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <stdexcept>
#include <string_view>

#include "models/mass_spring_model.hpp"
#include "msm/springs_with_volume.hpp"

namespace livermark::models::families {

namespace {

core::Model model(const msm::SpringLaw &law, const msm::VolumeTerm &term, const ModelOptions &options) {
    return mass_spring_model(
        fmt::format("{}_{}", law.name, term.name), fmt::format("{}, with {}", law.summary, term.summary),
        fmt::format("{}; {}", law.source, term.source),
        [law, term](const core::Body &body) {
            return livermark::msm::springs_with_volume(body, livermark::msm::springs_beside_volume(body, law), term);
        },
        options);
}

const msm::SpringLaw &find_law(std::string_view name) {
    const auto table = livermark::msm::all_spring_laws();
    const auto found = std::ranges::find(table, name, &livermark::msm::SpringLaw::name);
    if (found == table.end())
        throw std::logic_error(fmt::format("there is no spring law {}", name));
    return *found;
}

/// Not every pair is worth its time in a run over everything.
constexpr std::array<std::array<std::string_view, 2>, 4> pairs{{
    {"lloyd", "nodal_volume"},
    {"patch", "nodal_volume"},
    {"van_gelder", "nodal_volume"},
    {"van_gelder", "tetrahedral_volume"},
}};

} // namespace

/// Springs and a volume term, under the name <law>_<volume term>.
ModelFamily msm_volume() {
    return {.name = {}, .models = [](const ModelOptions &options) {
                std::vector<core::Model> models;
                for (const auto &[law, term] : pairs)
                    models.push_back(model(find_law(law), livermark::msm::find_volume_term(term), options));
                return models;
            }};
}

} // namespace livermark::models::families
