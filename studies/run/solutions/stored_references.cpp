#include "studies/run/solutions/stored_references.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>

#include "core/error_norms.hpp"
#include "core/observed_error.hpp"
#include "models/model_table.hpp"
#include "results/hdf5/files/reference_file.hpp"
#include "results/provenance.hpp"
#include "studies/run/solutions/solution_cache.hpp"
#include "support/input_error.hpp"
#include "support/root_folder.hpp"

namespace livermark::studies {

namespace {

/// What large deformations are judged by. That of linear elasticity is solved in every run.
bool judges_large_deformations(const core::Model &model) {
    const auto role = model.role_at_rest(core::Regime::large);
    return role == core::Role::reference || role == core::Role::refined_reference;
}

/// What large motions are judged by.
bool judges_large_motion(const core::Model &model) {
    return model.role_in_motion(core::Regime::large) == core::Role::reference;
}

/// What tells how good the motion is that others are judged by. It is solved where somebody asks for it alone: that
/// takes longer than a run.
bool refines_motion(const core::Model &model) {
    return model.in_motion == core::Role::refined_reference;
}

bool can_be_kept(const core::Model &model) {
    return judges_large_deformations(model) || judges_large_motion(model) || refines_motion(model);
}

bool is_there(const std::filesystem::path &folder, const core::Problem &problem, const std::string &model) {
    std::error_code nobody_cares;
    return std::filesystem::exists(results::reference_path(folder, problem, model), nobody_cares);
}

/// What the solver of a reference says, behind which follows by what its bar was widened.
constexpr auto *widened_by = "; error bar widened by ";

/// A bar that was widened stays as wide when its reference is solved again.
void keep_widened(const core::Solution &before, core::Solution &solution) {
    const auto sentence = before.solver.find(widened_by);
    if (sentence == std::string::npos || !before.observed_error)
        return;
    solution.observed_error = before.observed_error;
    solution.solver += before.solver.substr(sentence);
}

/// @throws support::InputError if it is no reference, or no solution to widen one by
void require_observed(const core::Solution &solution, const std::string &whose) {
    if (solution.status != core::SolutionStatus::ok || !solution.observed_error)
        throw support::InputError(whose + " has no solution to the whole load whose error was observed; its bar tells "
                                          "nothing");
}

} // namespace

bool is_stored(const core::Model &model, const core::Problem &problem) {
    if (!model.takes_part_in(problem))
        return false;
    if (refines_motion(model))
        return problem.load_case.release.has_value();
    return problem.load_case.regime == core::Regime::large &&
           (judges_large_deformations(model) || (judges_large_motion(model) && problem.load_case.release));
}

std::filesystem::path stored_references_folder() {
    return support::root_folder() / "results" / "references";
}

void leave_out_unsolved_motions(std::vector<core::Model> &models, const std::filesystem::path &folder) {
    for (auto &model : models)
        if (refines_motion(model))
            model.is_wanted = [name = model.name, folder](const core::Problem &problem) {
                return is_there(folder, problem, name);
            };
}

void use_stored_references(std::vector<core::Model> &models, const std::filesystem::path &folder) {
    leave_out_unsolved_motions(models, folder);
    for (auto &model : models)
        if (can_be_kept(model))
            model = cached(model, SolutionCache(folder));
}

StoredSolution solve_and_store(const core::Model &model, const core::Problem &problem,
                               const std::filesystem::path &folder, bool only_check, const std::string &command_line) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const auto file = results::reference_path(folder, problem, model.name);
    const auto before = results::read_reference(file, problem, model.name);
    auto solution = model.solve(problem);
    if (before)
        keep_widened(*before, solution);
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

WidenedBar widen_stored(const core::Problem &problem, const results::ModelResult &other,
                        const std::filesystem::path &folder, const std::string &command_line) {
    const auto models = models_to_keep();
    const auto refined = std::ranges::find_if(models, [](const core::Model &model) {
        return model.role_at_rest(core::Regime::large) == core::Role::refined_reference;
    });
    const auto file = results::reference_path(folder, problem, refined->name);
    auto stored = results::read_reference(file, problem, refined->name);
    const auto place = fmt::format("{} on {}", problem.load_case.name, problem.body->name);
    if (!stored)
        throw support::InputError(fmt::format("there is no stored reference of {} with this mesh, material and load; "
                                              "'livermark reference' makes one",
                                              place));
    require_observed(*stored, fmt::format("the stored reference of {}", place));
    require_observed(other.solution, fmt::format("{} of {}", other.name, place));
    const auto &mesh = problem.body->mesh;
    WidenedBar bar{.file = file,
                   .before = *stored->observed_error,
                   .now = core::widened(mesh, problem.load_case, *stored, other.solution),
                   .apart = core::compare(mesh, problem.load_case, *stored, other.solution, other.name),
                   .of_other = *other.solution.observed_error};
    stored->observed_error = bar.now;
    if (stored->solver.find(widened_by) == std::string::npos)
        stored->solver += widened_by + other.name;
    results::write_reference(file, *stored, problem, refined->name, results::current_provenance(command_line));
    return bar;
}

std::vector<core::Model> models_to_keep() {
    auto models = models::all_models();
    std::erase_if(models, [](const core::Model &model) { return !can_be_kept(model); });
    return models;
}

} // namespace livermark::studies
