#include "studies/run/solutions/stored_references.hpp"

#include <limits>

#include "core/error_norms.hpp"
#include "models/model_table.hpp"
#include "results/hdf5/references.hpp"
#include "results/provenance.hpp"
#include "studies/run/solutions/solution_cache.hpp"
#include "support/root_folder.hpp"

namespace livermark::studies {

namespace {

/// What judges at rest, but for linear elasticity on the mesh itself, which takes a second.
bool judges_at_rest(const core::Model &model, core::Regime regime) {
    const auto role = model.role_at_rest(regime);
    return role == core::Role::refined_reference || (role == core::Role::reference && regime == core::Regime::large);
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
    return judges_at_rest(model, core::Regime::small) || judges_at_rest(model, core::Regime::large) ||
           judges_large_motion(model) || refines_motion(model);
}

} // namespace

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

void leave_out_unsolved_motions(std::vector<core::Model> &models, const std::filesystem::path &folder) {
    for (auto &model : models)
        if (refines_motion(model))
            model.is_wanted = [solved = SolutionCache(folder), model](const core::Problem &problem) {
                return !solved.where(model, problem).empty();
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

} // namespace livermark::studies
