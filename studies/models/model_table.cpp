#include "studies/models/model_table.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <functional>
#include <iterator>

namespace livermark::models {

std::vector<double> ModelOptions::sweep_of(std::string_view constant) const {
    const auto found = sweeps.find(std::string(constant));
    return found == sweeps.end() ? std::vector<double>{} : found->second;
}

std::string swept_name(std::string_view constant, double value) {
    auto name = fmt::format("{}_{}", constant, value);
    std::ranges::replace(name, '.', '_');
    return name;
}

namespace {

/// Other models that cost as much are closer to the reference in displacement and in stiffness at the tool
/// (docs/studies/models.md), so a run over everything has no time for these.
constexpr std::array<std::string_view, 5> dominated{"lloyd_edge", "lloyd_mean_edge", "lloyd_nodal_volume", "uniform",
                                                    "van_gelder_tetrahedral_volume"};

/// @param role  of a model
/// @return an empty name if none has it
std::string name_with(core::Role role, const std::function<core::Role(const core::Model &)> &role_of) {
    const auto models = all_models();
    const auto found = std::ranges::find(models, role, role_of);
    return found == models.end() ? std::string() : found->name;
}

ReferenceNames names_of(const std::function<core::Role(const core::Model &)> &role_of) {
    return {name_with(core::Role::reference, role_of), name_with(core::Role::refined_reference, role_of)};
}

} // namespace

ReferenceNames static_reference(core::Regime regime) {
    return names_of([regime](const core::Model &model) { return model.role_at_rest(regime); });
}

ReferenceNames moving_reference(core::Regime regime) {
    return names_of([regime](const core::Model &model) { return model.role_in_motion(regime); });
}

std::string baseline_name() {
    return name_with(core::Role::baseline, &core::Model::at_rest);
}

std::vector<core::Model> all_models(const ModelOptions &options) {
    std::vector<core::Model> models;
    for (const auto &family : all_families())
        std::ranges::move(family.models(options), std::back_inserter(models));
    for (auto &model : models)
        if (std::ranges::find(dominated, model.name) != dominated.end())
            model.only_when_named = true;
    return models;
}

} // namespace livermark::models
