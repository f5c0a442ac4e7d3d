#include "studies/run/benchmark_case.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "core/support/input_error.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "core/units.hpp"
#include "studies/models/model_table.hpp"

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

/// Comparison up to the part of the load that a reference on the mesh has come to, where none has a solution to all of
/// it.
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

/// What a model is called in the rows, and what it did at the amplitudes so far.
struct AmplitudeRow {
    std::vector<std::string> key; ///< body, load case, model
    std::vector<std::string> cells;
    double fair_up_to = 0.0; ///< amplitude
    bool is_fair = true;     ///< at all amplitudes so far
};

AmplitudeRow &find_row(std::vector<AmplitudeRow> &rows, std::vector<std::string> key, std::size_t num_columns) {
    const auto found = std::ranges::find(rows, key, &AmplitudeRow::key);
    return found != rows.end()
               ? *found
               : rows.emplace_back(AmplitudeRow{std::move(key), std::vector<std::string>(num_columns, "-")});
}

void enter(AmplitudeRow &row, const core::Solution &solution, std::size_t column, double amplitude) {
    const bool is_solved = solution.status == core::SolutionStatus::ok;
    row.cells[column] =
        is_solved ? results::fixed(core::percent * solution.nonlinearity, 2) : core::to_string(solution.status);
    row.is_fair = row.is_fair && is_solved && solution.nonlinearity < fair_nonlinearity;
    if (row.is_fair)
        row.fair_up_to = amplitude;
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

results::Layout nonlinearity_by_amplitude(std::span<const results::Result> results,
                                          std::span<const double> amplitudes) {
    results::Layout layout{{{"body"}, {"load case"}, {"model"}}, {}};
    for (const double amplitude : amplitudes)
        layout.columns.push_back({fmt::format("x {:g} [%]", amplitude), true});
    layout.columns.push_back({fmt::format("below {:g} % up to", core::percent * fair_nonlinearity), true});
    std::vector<AmplitudeRow> rows;
    for (std::size_t column = 0; column < amplitudes.size(); ++column)
        for (const auto &result : results) {
            const auto &name = result.problem.load_case.name;
            const auto end = fmt::format("@{:g}", amplitudes[column]);
            if (!name.ends_with(end))
                continue;
            for (const auto &model : result.models)
                if (model.solution.springs || !std::isnan(model.solution.nonlinearity))
                    enter(find_row(rows,
                                   {result.problem.body->name, name.substr(0, name.size() - end.size()), model.name},
                                   amplitudes.size()),
                          model.solution, column, amplitudes[column]);
        }
    for (auto &row : rows) {
        layout.rows.push_back(std::move(row.key));
        layout.rows.back().insert(layout.rows.back().end(), row.cells.begin(), row.cells.end());
        layout.rows.back().push_back(row.fair_up_to > 0.0 ? fmt::format("x {:g}", row.fair_up_to) : "none");
    }
    return layout;
}

} // namespace livermark::studies
