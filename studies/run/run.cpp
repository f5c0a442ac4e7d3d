#include "studies/run/run.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <memory>
#include <utility>

#include "core/support/input_error.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "core/units.hpp"
#include "results/records/springs.hpp"
#include "studies/models/model_table.hpp"
#include "studies/study.hpp"

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
            auto frame_comparison = core::compare(*model.solution.history, *on_mesh->solution.history, on_mesh->name);
            history.error = std::move(frame_comparison.error);
            history.frames_reference = std::move(frame_comparison.frames_reference);
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

/// Names of a model in the rows, and its cells at the amplitudes so far.
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

/// The model of RunOptions::calibration.
constexpr auto *calibrated_springs = "calibrated_nodal_volume";

void refuse_on_several_ranks(const RunOptions &options) {
    if (support::mpi_num_ranks() == 1)
        return;
    using enum fem_reference::SolverChoice;
    for (const auto &[is_asked_for, option] : {std::pair{options.resume, "--resume"},
                                               {options.model_options.fem_solver == direct, "--fem-solver direct"},
                                               {options.jobs.value_or(1) > 1, "--jobs"}})
        if (is_asked_for)
            throw support::InputError(
                fmt::format("{} works on one rank only; leave it out or start without mpirun", option));
}

models::ModelOptions model_options(const RunOptions &options) {
    auto chosen = options.model_options;
    if (options.calibration.empty() && std::ranges::find(options.models, calibrated_springs) != options.models.end())
        throw support::InputError(
            fmt::format("model {} takes its springs from a file; name it with --calibration, or make "
                        "one with `python3 -m livermark.calibration`",
                        calibrated_springs));
    if (!options.calibration.empty())
        chosen.calibration =
            std::make_shared<const core::CalibratedSprings>(results::read_calibration(options.calibration).springs);
    return chosen;
}

/// Springs that are swept, and those of a calibration, run beside the models asked for by name.
std::vector<std::string> wanted_models(const RunOptions &options) {
    auto wanted = options.models;
    if (!wanted.empty() && !options.calibration.empty())
        wanted.emplace_back(calibrated_springs);
    if (!wanted.empty())
        for (const auto &[constant, values] : options.model_options.sweeps)
            for (const double value : values)
                wanted.push_back(models::swept_name(constant, value));
    return wanted;
}

ProblemSet read_all_problems(const RunOptions &options) {
    if (options.poisson_ratios.empty())
        return read_problems(options.bodies, options.load_cases, {options.young_modulus, {}}, options.may_leave_out);
    ProblemSet all;
    for (const double poisson_ratio : options.poisson_ratios) {
        auto some = read_problems(options.bodies, options.load_cases, {options.young_modulus, poisson_ratio},
                                  options.may_leave_out);
        std::ranges::move(some.problems, std::back_inserter(all.problems));
        all.notes = std::move(some.notes); // they are the same for every Poisson's ratio
        all.left_out = std::move(some.left_out);
    }
    return all;
}

/// @throws support::InputError if a load case that was asked for by name is not of the regime that was asked for
void refuse_other_regime(const RunOptions &options, core::Regime regime, const std::string &load_case) {
    const auto &asked_for = options.regimes;
    if (options.load_cases.empty() || !options.has_asked_for_regime ||
        std::ranges::find(asked_for, regime) != asked_for.end())
        return;
    const auto *const wanted = core::to_string(asked_for.front());
    throw support::InputError(
        fmt::format("--regime {}: load case {} is of the {} regime{}; write regime = \"{}\" into its "
                    "file, or leave --regime out",
                    wanted, load_case, core::to_string(regime),
                    regime == core::Regime::small ? ", as is each that names none" : "", wanted));
}

/// The problems that were asked for, and those of them that fit no body.
/// @throws support::InputError if none fits
ProblemSet wanted_problems(const RunOptions &options) {
    auto read = read_all_problems(options);
    for (const auto &problem : read.problems)
        refuse_other_regime(options, problem.load_case.regime, problem.load_case.name);
    for (const auto &left_out : read.left_out)
        refuse_other_regime(options, left_out.kind.regime, left_out.load_case);
    const auto is_left_aside = [&](core::Regime regime, bool depends_on_time) {
        return (options.only_static && depends_on_time) ||
               (options.load_cases.empty() && std::ranges::find(options.regimes, regime) == options.regimes.end());
    };
    std::erase_if(read.problems, [&](const core::Problem &problem) {
        return is_left_aside(problem.load_case.regime, problem.load_case.in_time());
    });
    std::erase_if(read.left_out, [&](const LeftOut &left_out) {
        return is_left_aside(left_out.kind.regime, left_out.kind.depends_on_time);
    });
    if (read.problems.empty() && !read.left_out.empty())
        throw support::InputError(
            fmt::format("{}; give another body, or another load case", sentences(read.left_out).front()));
    return read;
}

/// A sentence for each load case in which time passes in the material, on the models that do not know of it.
/// @throws support::InputError on several ranks, which follow none
std::vector<std::string> without_part_in_slow_histories(const Run &run) {
    std::vector<std::string> sentences;
    for (const auto &problem : run.problems) {
        if (!problem.load_case.slow_history)
            continue;
        if (support::mpi_num_ranks() > 1)
            throw support::InputError(fmt::format("load case {} has a history of tissue that relaxes, which is solved "
                                                  "on one rank only; start without mpirun",
                                                  problem.load_case.name));
        std::vector<std::string> names;
        for (const auto &model : run.models)
            if (!model.follows.has<core::SlowHistory>() && !model.only_moving &&
                model.only.value_or(problem.load_case.regime) == problem.load_case.regime)
                names.push_back(model.name);
        auto sentence = fmt::format("{}: these models have no material that relaxes, and are left out: {}",
                                    problem.load_case.name, fmt::join(names, ", "));
        if (!names.empty() && std::ranges::find(sentences, sentence) == sentences.end())
            sentences.push_back(std::move(sentence));
    }
    return sentences;
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

std::filesystem::path Run::result_file(const core::Problem &problem) const {
    auto folder = std::filesystem::path(options.output);
    if (!options.poisson_ratios.empty())
        folder /= fmt::format("poisson_{:g}", problem.body->materials.front().poisson_ratio);
    return folder / problem.body->name / (problem.load_case.name + ".h5");
}

Run read_run(const RunOptions &options) {
    refuse_on_several_ranks(options);
    Run run{options, choose_models(wanted_models(options), model_options(options), !options.reference_on_mesh),
            baseline_of(models::all_models(options.model_options))};
    auto read = wanted_problems(options);
    run.problems = std::move(read.problems);
    run.notes = std::move(read.notes);
    run.left_out = std::move(read.left_out);
    std::ranges::move(yielded_places(run.problems), std::back_inserter(run.notes));
    std::ranges::move(without_part_in_slow_histories(run), std::back_inserter(run.notes));
    if (!options.solve_reference) {
        run.solutions = SolutionCache::shipped();
        leave_out_unsolved_motions(run.models);
    }
    if (support::mpi_rank() == 0)
        for (const auto &problem : run.problems)
            for (const auto &model : run.models)
                if (model.check)
                    model.check(problem);
    return run;
}

// A fault of one rank, say a file that only one machine has, is a fault of all: none may go on alone.
Run prepare(const RunOptions &options) {
    std::optional<Run> run;
    std::string fault;
    try {
        run = read_run(options);
        if (support::mpi_rank() == 0)
            for (const auto &problem : run->problems)
                const OutputFolder can_be_made(run->result_file(problem).parent_path());
    } catch (const support::InputError &error) {
        fault = error.what();
    }
    fault = support::first_text_of_ranks(fault);
    if (!fault.empty())
        throw support::InputError(fault);
    return std::move(*run);
}

} // namespace livermark::studies
