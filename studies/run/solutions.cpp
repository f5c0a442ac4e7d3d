#include "studies/run/run.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <limits>
#include <system_error>
#include <utility>

#include "core/error_norms.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "core/support/processes/own_process.hpp"
#include "core/units.hpp"
#include "results/hdf5/references.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/records/result.hpp"
#include "studies/models/model_table.hpp"

namespace livermark::studies {

namespace {

constexpr auto *solutions_folder = ".solutions";

bool is_file(const std::filesystem::path &path) {
    std::error_code nobody_cares;
    return std::filesystem::is_regular_file(path, nobody_cares);
}

/// Models that judge at rest, but for linear elasticity on the mesh itself, which takes a second.
bool judges_at_rest(const core::Model &model, core::Regime regime) {
    const auto role = model.role_at_rest(regime);
    return role == core::Role::refined_reference || (role == core::Role::reference && regime == core::Regime::large);
}

/// Models that large motions are judged by.
bool judges_large_motion(const core::Model &model) {
    return model.role_in_motion(core::Regime::large) == core::Role::reference;
}

/// Models that tell how good the motion is that others are judged by. They are solved where somebody asks for it alone:
/// that takes longer than a run.
bool refines_motion(const core::Model &model) {
    return model.in_motion == core::Role::refined_reference;
}

bool can_be_kept(const core::Model &model) {
    return judges_at_rest(model, core::Regime::small) || judges_at_rest(model, core::Regime::large) ||
           judges_large_motion(model) || refines_motion(model);
}

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
        // Both are that of the mesh if no finer mesh has a solution, and nothing is known of its error then.
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

} // namespace

SolutionCache SolutionCache::shipped() {
    return SolutionCache(stored_references_folder());
}

void SolutionCache::keep_in(const std::filesystem::path &output, const std::string &settings) {
    support::FnvHash hash;
    hash.add(settings);
    folder_ = output / solutions_folder / fmt::format("{:016x}", hash.value());
}

std::filesystem::path SolutionCache::file(const core::Model &model, const core::Problem &problem) const {
    return folder_ / problem.body->name / fmt::format("{}.{}.solution", model.name, results::problem_key(problem));
}

std::filesystem::path SolutionCache::stored_file(const core::Model &model, const core::Problem &problem) const {
    std::error_code nobody_cares;
    // Names of files take a hash of the mesh, which is in vain where no reference of the body ships.
    if (references_.empty() || !is_stored(model, problem) ||
        !std::filesystem::is_directory(references_ / problem.body->name, nobody_cares))
        return {};
    auto path = results::reference_path(references_, problem, model.name);
    return is_file(path) ? path : std::filesystem::path();
}

std::string SolutionCache::where(const core::Model &model, const core::Problem &problem) const {
    if (!folder_.empty() && is_file(file(model, problem)))
        return "kept";
    return stored_file(model, problem).empty() ? "" : "stored";
}

std::optional<core::Solution> SolutionCache::find(const core::Model &model, const core::Problem &problem) const {
    if (const auto path = folder_.empty() ? folder_ : file(model, problem); is_file(path))
        try {
            return results::read_solution(path, problem);
        } catch (const support::InputError &) {
            // It is solved again.
        }
    const auto path = stored_file(model, problem);
    return path.empty() ? std::nullopt : results::read_reference(path, problem, model.name);
}

void SolutionCache::keep(const core::Model &model, const core::Problem &problem, const core::Solution &solution) const {
    if (folder_.empty())
        return;
    const auto path = file(model, problem);
    std::error_code nobody_cares; // writing says it
    std::filesystem::create_directories(path.parent_path(), nobody_cares);
    results::write_solution(path, solution, problem.load_case);
}

void SolutionCache::forget(std::span<const core::Model> models, const core::Problem &problem) const {
    if (folder_.empty())
        return;
    std::error_code nobody_cares;
    for (const auto &model : models)
        std::filesystem::remove(file(model, problem), nobody_cares);
}

void SolutionCache::clear() const {
    if (folder_.empty())
        return;
    std::error_code nobody_cares;
    std::filesystem::remove_all(folder_, nobody_cares);
    std::filesystem::remove(folder_.parent_path(), nobody_cares); // that of all runs, if there is no other
}

bool is_stored(const core::Model &model, const core::Problem &problem) {
    if (!model.takes_part_in(problem))
        return false;
    if (refines_motion(model))
        return problem.load_case.release.has_value();
    const auto regime = problem.load_case.regime;
    return judges_at_rest(model, regime) ||
           (regime == core::Regime::large && judges_large_motion(model) && problem.load_case.release);
}

std::filesystem::path stored_references_folder() {
    return support::root_folder() / "results" / "references";
}

void leave_out_unsolved_motions(std::vector<core::Model> &models) {
    for (auto &model : models)
        if (refines_motion(model))
            model.is_wanted = [solved = SolutionCache::shipped(), model](const core::Problem &problem) {
                return !solved.where(model, problem).empty();
            };
}

StoredSolution solve_and_store(const core::Model &model, const core::Problem &problem,
                               const std::filesystem::path &folder, bool only_check, const std::string &command_line) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const auto file = results::reference_path(folder, problem, model.name);
    const auto before = results::read_reference(file, problem, model.name);
    const auto solution = model.solve(problem);
    StoredSolution stored{file, solution.status, solution.message, nan, nan, nan};
    if (before && solution.status == core::SolutionStatus::ok) {
        const auto comparison = core::compare(problem.body->mesh, problem.load_case, solution, *before, "stored");
        stored.difference = comparison.relative_l2;
        stored.reaction_difference = comparison.reaction_error;
        if (solution.history && before->history)
            stored.motion_difference = core::compare(*solution.history, *before->history, "stored").relative_l2;
    }
    if (only_check || solution.status != core::SolutionStatus::ok)
        return stored;
    std::error_code fault;
    std::filesystem::create_directories(file.parent_path(), fault);
    results::write_reference(file, solution, problem, model.name, results::current_provenance(command_line));
    return stored;
}

std::vector<core::Model> models_to_keep() {
    auto models = models::all_models();
    std::erase_if(models, [](const core::Model &model) { return !can_be_kept(model); });
    return models;
}

core::Solution PreparedModels::solve(const core::Model &model, const core::Problem &problem) {
    return std::move(solve(model, std::span(&problem, 1)).front());
}

std::vector<core::Solution> PreparedModels::solve(const core::Model &model, std::span<const core::Problem> problems) {
    if (body_ != problems.front().body)
        clear();
    body_ = problems.front().body;
    std::vector<std::optional<core::Solution>> found;
    for (const auto &problem : problems)
        found.push_back(cache_.find(model, problem));
    // The last digits depend on what is solved together, so that it is solved together again; what is stored was
    // solved alone.
    if (model.most_together > 1 && !std::ranges::all_of(found, &std::optional<core::Solution>::has_value))
        for (std::size_t i = 0; i < found.size(); ++i)
            if (cache_.where(model, problems[i]) != "stored")
                found[i].reset();
    std::vector<core::LoadCase> missing;
    for (std::size_t i = 0; i < found.size(); ++i)
        if (!found[i])
            missing.push_back(problems[i].load_case);
    std::vector<core::Solution> solved;
    if (!missing.empty()) {
        auto &prepared = prepared_[model.name];
        if (!prepared) {
            const auto common = std::ranges::find(common_, body_, &core::Problem::body);
            prepared = model.prepare(body_, common != common_.end() ? &common->load_case : nullptr);
        }
        solved = prepared->solve(missing);
    }
    auto next = solved.begin();
    std::vector<core::Solution> solutions;
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (!found[i])
            try {
                cache_.keep(model, problems[i], *next);
            } catch (const support::InputError &) {
                // Such as a full disk: the solution is there all the same.
            }
        solutions.push_back(found[i] ? *std::move(found[i]) : std::move(*next++));
    }
    return solutions;
}

void PreparedModels::clear() {
    if (prepared_.empty())
        return;
    prepared_.clear();
    body_.reset();
    support::return_freed_memory();
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
            for (const auto &model : result.models) {
                const auto &solution = model.solution;
                if (!solution.springs && std::isnan(solution.nonlinearity))
                    continue;
                const std::vector<std::string> key{result.problem.body->name, name.substr(0, name.size() - end.size()),
                                                   model.name};
                auto row = std::ranges::find(rows, key, &AmplitudeRow::key);
                if (row == rows.end())
                    row = rows.insert(
                        row, AmplitudeRow{.key = key, .cells = std::vector<std::string>(amplitudes.size(), "-")});
                const bool is_solved = solution.status == core::SolutionStatus::ok;
                row->cells[column] = is_solved ? results::fixed(core::percent * solution.nonlinearity, 2)
                                               : core::to_string(solution.status);
                row->is_fair = row->is_fair && is_solved && solution.nonlinearity < fair_nonlinearity;
                if (row->is_fair)
                    row->fair_up_to = amplitudes[column];
            }
        }
    for (auto &row : rows) {
        layout.rows.push_back(std::move(row.key));
        layout.rows.back().insert(layout.rows.back().end(), row.cells.begin(), row.cells.end());
        layout.rows.back().push_back(row.fair_up_to > 0.0 ? fmt::format("x {:g}", row.fair_up_to) : "none");
    }
    return layout;
}

} // namespace livermark::studies
