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

using core::Role;

/// The models of a result, in its order.
using TakingPart = std::vector<const core::Model *>;

/// @return nullptr if no model has the role at rest, or it found no solution
const results::ModelResult *find_solved(const results::Result &result, const TakingPart &models, Role role) {
    for (std::size_t m = 0; m < models.size(); ++m)
        if (models[m]->role_at_rest(result.problem.load_case.regime) == role)
            return result.models[m].solution.status == core::SolutionStatus::ok ? &result.models[m] : nullptr;
    return nullptr;
}

/// @return nullptr if no model has the role in motion, or it did not move
const results::ModelResult *find_moving(const results::Result &result, const TakingPart &models, Role role) {
    for (std::size_t m = 0; m < models.size(); ++m)
        if (models[m]->role_in_motion(result.problem.load_case.regime) == role) {
            const auto &solution = result.models[m].solution;
            return solution.status == core::SolutionStatus::ok && solution.history ? &result.models[m] : nullptr;
        }
    return nullptr;
}

/// Adds what motions are off to the comparisons.
void compare_motion(results::Result &result, const TakingPart &models) {
    const auto *on_mesh = find_moving(result, models, Role::reference);
    const auto *refined = find_moving(result, models, Role::refined_reference);
    if (!on_mesh)
        return;
    const auto *reference = on_mesh;
    if (refined) {
        result.motion_uncertainty = results::estimate_motion_uncertainty(*on_mesh->solution.history, on_mesh->name,
                                                                         *refined->solution.history, refined->name);
        if (result.motion_uncertainty->reference == refined->name)
            reference = refined;
    } else {
        result.motion_uncertainty = results::uncertainty_of_steps(*on_mesh->solution.history, on_mesh->name);
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

/// Where no reference has a solution to the whole load, one on the mesh may have come to a part of it.
void compare_as_far_as_reached(results::Result &result, const TakingPart &models) {
    const auto &load_case = result.problem.load_case;
    for (std::size_t m = 0; m < models.size(); ++m) {
        const auto &reference = result.models[m];
        if (models[m]->role_at_rest(load_case.regime) != Role::reference ||
            core::num_points_reached(load_case, reference.solution) == 0)
            continue;
        for (auto &model : result.models)
            if (&model != &reference)
                model.comparison = core::compare_as_far_as_reached(result.problem.body->mesh, load_case, model.solution,
                                                                   reference.solution, reference.name);
        return;
    }
}

/// Relative L2 difference of two ways to the same solution; iterations leave less.
constexpr double same_solution = 1e-6;

void compare_with_reference(results::Result &result, const TakingPart &models) {
    const auto &mesh = result.problem.body->mesh;
    const auto &load_case = result.problem.load_case;
    const auto *reference = find_solved(result, models, Role::reference);
    const auto *refined = reference ? find_solved(result, models, Role::refined_reference) : nullptr;
    if (!reference)
        reference = find_solved(result, models, Role::substitute_reference);
    if (!reference)
        return compare_as_far_as_reached(result, models);
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
    compare_motion(result, models);
}

} // namespace

std::vector<core::Model> choose_models(const std::vector<std::string> &wanted, const models::ModelOptions &options,
                                       bool with_uncertainty) {
    auto models = models::all_models(options);
    for (const auto &name : wanted)
        support::find_named(models, name, "model");
    std::erase_if(models, [&](const core::Model &model) {
        if (std::ranges::find(wanted, model.name) != wanted.end())
            return false;
        if (model.only_when_named)
            return true;
        if (model.at_rest == Role::refined_reference || model.in_motion == Role::refined_reference)
            return !with_uncertainty;
        return !wanted.empty() && model.at_rest != Role::reference && model.in_motion != Role::reference;
    });
    for (auto &model : models)
        if (model.in_motion == Role::reference && !wanted.empty() &&
            std::ranges::find(wanted, model.name) == wanted.end())
            model.only_moving = true;
    return models;
}

const core::Model &baseline_of(const std::vector<core::Model> &models) {
    return *std::ranges::find(models, Role::baseline, &core::Model::at_rest);
}

bool may_fail(const std::string &model, core::Regime regime) {
    if (regime != core::Regime::large)
        return false;
    const auto known = models::all_models();
    const auto found = std::ranges::find(known, model, &core::Model::name);
    return found == known.end() || (found->at_rest != Role::reference && found->at_rest != Role::substitute_reference);
}

results::Result evaluate(const core::Problem &problem, const std::vector<core::Model> &models, const SolveModel &solve,
                         results::Provenance provenance) {
    results::Result result{
        .provenance = std::move(provenance), .problem = problem, .models = {}, .reference_uncertainty = {}};
    TakingPart taking_part;
    for (const auto &model : models)
        if (model.takes_part_in(problem))
            taking_part.push_back(&model);
    for (const auto *model : taking_part)
        result.models.push_back({.name = model->name,
                                 .summary = model->summary,
                                 .source = model->source,
                                 .solution = {},
                                 .comparison = {}});
    const bool is_first_rank = support::mpi_rank() == 0;
    for (const bool is_collective : {true, false})
        for (std::size_t m = 0; m < taking_part.size(); ++m)
            if (taking_part[m]->is_collective == is_collective && (is_collective || is_first_rank))
                result.models[m].solution = solve(*taking_part[m], problem);
    if (is_first_rank)
        compare_with_reference(result, taking_part);
    return result;
}

} // namespace livermark::studies
