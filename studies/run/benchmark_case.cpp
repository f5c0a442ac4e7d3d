#include "studies/run/benchmark_case.hpp"

#include <algorithm>
#include <utility>

#include "models/model_table.hpp"
#include "studies/catalogue.hpp"
#include "support/input_error.hpp"
#include "support/known_names.hpp"
#include "support/processes/mpi_session.hpp"

namespace livermark::studies {

namespace {

/// @return nullptr if the model is not there or found no solution
const results::ModelResult *find_solved(const results::Result &result, std::string_view name) {
    const auto found = std::ranges::find(result.models, name, &results::ModelResult::name);
    return found != result.models.end() && found->solution.status == core::SolutionStatus::ok ? &*found : nullptr;
}

/// @return nullptr if the model is not there or did not move
const results::ModelResult *find_moving(const results::Result &result, std::string_view name) {
    const auto *found = find_solved(result, name);
    return found && found->solution.history ? found : nullptr;
}

/// Adds what motions are off to the comparisons.
void compare_motion(results::Result &result) {
    const auto names = models::moving_reference(result.problem.load_case.regime);
    const auto *on_mesh = find_moving(result, names.on_mesh);
    const auto *refined = find_moving(result, names.refined);
    if (!on_mesh)
        return;
    const auto *reference = on_mesh;
    if (refined) {
        result.motion_uncertainty = results::estimate_motion_uncertainty(*on_mesh->solution.history, on_mesh->name,
                                                                         *refined->solution.history, refined->name);
        if (result.motion_uncertainty->reference == refined->name)
            reference = refined;
    }
    const auto &motion = *reference->solution.history;
    for (auto &model : result.models) {
        if (!model.comparison || &model == reference || !model.solution.history)
            continue;
        auto &history =
            model.comparison->history.emplace(core::compare(*model.solution.history, motion, reference->name));
        if (history.error.empty() && &model != on_mesh) {
            auto of_frames = core::compare(*model.solution.history, *on_mesh->solution.history, on_mesh->name);
            history.error = std::move(of_frames.error);
            history.frames_reference = std::move(of_frames.frames_reference);
        }
    }
}

/// Relative L2 difference of two ways to the same solution; iterations leave less.
constexpr double same_solution = 1e-6;

void compare_with_reference(results::Result &result) {
    const auto &mesh = result.problem.body->mesh;
    const auto &load_case = result.problem.load_case;
    const auto regime = load_case.regime;
    const auto found = std::ranges::find_if(models::references, [&](const auto &candidate) {
        return candidate.regime == regime && find_solved(result, candidate.on_mesh);
    });
    if (found == models::references.end())
        return;
    const auto *reference = find_solved(result, found->on_mesh);
    const auto *refined = find_solved(result, found->refined);
    if (refined && refined->solution.observed_error) {
        const auto &error = *refined->solution.observed_error;
        result.reference_uncertainty = {.reference = refined->name,
                                        .refined = refined->name,
                                        .refinement_difference = error.difference,
                                        .order = error.order,
                                        .relative_l2 = error.relative_l2,
                                        .energy_error = error.energy,
                                        .reaction_error = error.reaction,
                                        .stiffness = error.stiffness};
        reference = refined;
    } else if (refined) {
        result.reference_uncertainty = results::estimate_uncertainty(mesh, load_case, reference->solution,
                                                                     reference->name, refined->solution, refined->name);
        if (result.reference_uncertainty->reference == refined->name)
            reference = refined;
        // Where no finer mesh has a solution, both are that of the mesh, and nothing is known of its error.
        if (result.reference_uncertainty->refinement_difference < same_solution)
            result.reference_uncertainty.reset();
    }
    for (auto &model : result.models)
        if (&model != reference)
            model.comparison = core::compare(mesh, load_case, model.solution, reference->solution, reference->name);
    compare_motion(result);
}

} // namespace

std::vector<core::Model> choose_models(const std::vector<std::string> &wanted, const models::ModelOptions &options,
                                       bool with_uncertainty) {
    auto models = models::all_models(options);
    for (const auto &name : wanted)
        support::find_named(models, name, "model");
    const auto measures_motion = [](const core::Model &model) {
        return model.name == models::moving_reference(core::Regime::small).on_mesh ||
               model.name == models::moving_reference(core::Regime::large).on_mesh;
    };
    // What judges only where another one finds no solution has no finer meshes.
    const auto judges_first = [](const core::Model &model) {
        const auto found = std::ranges::find(models::references, model.name, &models::Reference::on_mesh);
        return found != models::references.end() && !found->refined.empty();
    };
    const auto refines_motion = [](const core::Model &model) {
        return model.name == models::moving_reference(core::Regime::small).refined ||
               model.name == models::moving_reference(core::Regime::large).refined;
    };
    std::erase_if(models, [&](const core::Model &model) {
        if (std::ranges::find(wanted, model.name) != wanted.end())
            return false;
        if (model.only_when_named)
            return true;
        const bool is_refined = std::ranges::find(models::references, model.name, &models::Reference::refined) !=
                                    models::references.end() ||
                                refines_motion(model);
        return is_refined ? !with_uncertainty : !wanted.empty() && !judges_first(model) && !measures_motion(model);
    });
    for (auto &model : models)
        if (measures_motion(model) && !wanted.empty() && std::ranges::find(wanted, model.name) == wanted.end())
            model.only_moving = true;
    return models;
}

const core::Model &baseline_of(const std::vector<core::Model> &models) {
    return *std::ranges::find(models, models::baseline_model, &core::Model::name);
}

bool may_fail(const std::string &model, core::Regime regime) {
    return regime == core::Regime::large &&
           std::ranges::find(models::references, model, &models::Reference::on_mesh) == models::references.end();
}

results::Result evaluate(const core::Problem &problem, const std::vector<core::Model> &models, const SolveModel &solve,
                         const results::ErrorBands &bands, results::Provenance provenance) {
    results::Result result{
        .provenance = std::move(provenance), .problem = problem, .models = {}, .reference_uncertainty = {}};
    std::vector<const core::Model *> taking_part;
    for (const auto &model : models)
        if (model.takes_part_in(problem))
            taking_part.push_back(&model);
    for (const auto *model : taking_part)
        result.models.push_back({.name = model->name,
                                 .summary = model->summary,
                                 .source = model->source,
                                 .solution = {},
                                 .comparison = {},
                                 .band = bands.find(problem.body->name, problem.load_case.name, model->name)});
    const bool is_first_rank = support::mpi_rank() == 0;
    for (const bool is_collective : {true, false})
        for (std::size_t m = 0; m < taking_part.size(); ++m)
            if (taking_part[m]->is_collective == is_collective && (is_collective || is_first_rank))
                result.models[m].solution = solve(*taking_part[m], problem);
    if (is_first_rank)
        compare_with_reference(result);
    return result;
}

} // namespace livermark::studies
