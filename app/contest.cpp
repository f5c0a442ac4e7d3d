#include "app/contest.hpp"

#include <algorithm>

#include "app/catalogue.hpp"
#include "core/input_error.hpp"
#include "models/model_table.hpp"

namespace livermark::app {

std::vector<core::Model> choose_models(const std::vector<std::string> &wanted) {
    auto models = models::all_models();
    if (wanted.empty())
        return models;
    std::vector<std::string> known;
    for (const auto &model : models)
        known.push_back(model.name);
    for (const auto &name : wanted)
        if (std::ranges::find(known, name) == known.end())
            throw core::InputError(unknown_name("model", name, known));
    std::erase_if(models, [&](const core::Model &model) {
        return model.name != models::reference_model && model.name != models::baseline_model &&
               std::ranges::find(wanted, model.name) == wanted.end();
    });
    return models;
}

results::Result hold_contest(const core::Problem &problem, const std::vector<core::Model> &models,
                             const results::ErrorBands &bands, results::Provenance provenance,
                             const std::function<void(const std::string &)> &starting) {
    results::Result result{.provenance = std::move(provenance), .problem = problem, .models = {}};
    for (const auto &model : models) {
        starting(model.name);
        result.models.push_back({.name = model.name,
                                 .summary = model.summary,
                                 .source = model.source,
                                 .solution = model.solve(problem),
                                 .comparison = {},
                                 .band = bands.find(problem.body->name, problem.load_case.name, model.name)});
    }
    const auto reference = std::ranges::find(result.models, models::reference_model, &results::ModelResult::name);
    if (reference != result.models.end() && reference->solution.status == core::SolutionStatus::ok)
        for (auto &model : result.models)
            if (model.name != models::reference_model)
                model.comparison =
                    core::compare(problem.body->mesh, model.solution, reference->solution, reference->name);
    return result;
}

} // namespace livermark::app
