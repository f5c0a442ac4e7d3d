#include "studies/run/solutions.hpp"

#include <algorithm>
#include <cstddef>
#include <fmt/format.h>
#include <limits>
#include <system_error>
#include <utility>

#include "core/error_norms.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/own_process.hpp"
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
    auto solved = missing.empty() ? std::vector<core::Solution>() : prepared(model).solve(missing);
    auto next = solved.begin();
    std::vector<core::Solution> solutions;
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (!found[i])
            keep(model, problems[i], *next);
        solutions.push_back(found[i] ? *std::move(found[i]) : std::move(*next++));
    }
    return solutions;
}

void PreparedModels::keep(const core::Model &model, const core::Problem &problem,
                          const core::Solution &solution) const {
    try {
        cache_.keep(model, problem, solution);
    } catch (const support::InputError &) {
        // Such as a full disk: the solution is there all the same.
    }
}

void PreparedModels::clear() {
    if (prepared_.empty())
        return;
    prepared_.clear();
    body_.reset();
    support::return_freed_memory();
}

core::PreparedModel &PreparedModels::prepared(const core::Model &model) {
    auto &prepared = prepared_[model.name];
    if (!prepared) {
        const auto common = std::ranges::find(common_, body_, &core::Problem::body);
        prepared = model.prepare(body_, common != common_.end() ? &common->load_case : nullptr);
    }
    return *prepared;
}

} // namespace livermark::studies
