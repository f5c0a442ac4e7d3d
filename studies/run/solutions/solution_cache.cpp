#include "studies/run/solutions/solution_cache.hpp"

#include <algorithm>
#include <cstddef>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "results/hdf5/references.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/problem_key.hpp"
#include "studies/run/solutions/stored_references.hpp"
#include "support/fnv_hash.hpp"
#include "support/input_error.hpp"

namespace livermark::studies {

namespace {

constexpr auto *solutions_folder = ".solutions";

bool is_file(const std::filesystem::path &path) {
    std::error_code nobody_cares;
    return std::filesystem::is_regular_file(path, nobody_cares);
}

class PreparedWithCache : public core::PreparedModel {
  public:
    PreparedWithCache(core::Model model, SolutionCache cache, std::shared_ptr<const core::Body> body,
                      const core::LoadCase *common)
        : model_(std::move(model)), cache_(std::move(cache)), body_(std::move(body)) {
        if (common)
            common_ = *common;
    }

    std::vector<core::Solution> solve(std::span<const core::LoadCase> load_cases) override {
        std::vector<std::optional<core::Solution>> found;
        for (const auto &load_case : load_cases)
            found.push_back(cache_.find(model_, {body_, load_case}));
        // The last digits depend on what is solved together, so that it is solved together again; what is stored was
        // solved alone.
        if (model_.most_together > 1 && !std::ranges::all_of(found, &std::optional<core::Solution>::has_value))
            for (std::size_t i = 0; i < found.size(); ++i)
                if (cache_.where(model_, {body_, load_cases[i]}) != "stored")
                    found[i].reset();
        std::vector<core::LoadCase> missing;
        for (std::size_t i = 0; i < found.size(); ++i)
            if (!found[i])
                missing.push_back(load_cases[i]);
        auto solved = solve_and_keep(missing);
        auto next = solved.begin();
        std::vector<core::Solution> solutions;
        for (auto &solution : found)
            solutions.push_back(solution ? *std::move(solution) : std::move(*next++));
        return solutions;
    }

  private:
    std::vector<core::Solution> solve_and_keep(std::span<const core::LoadCase> load_cases) {
        if (load_cases.empty())
            return {};
        if (!prepared_)
            prepared_ = model_.prepare(body_, common_ ? &*common_ : nullptr);
        auto solutions = prepared_->solve(load_cases);
        try {
            for (std::size_t i = 0; i < load_cases.size(); ++i)
                cache_.keep(model_, {body_, load_cases[i]}, solutions[i]);
        } catch (const support::InputError &) {
            // Such as a full disk: who asked has the solutions all the same.
        }
        return solutions;
    }

    core::Model model_;
    SolutionCache cache_;
    std::shared_ptr<const core::Body> body_;
    std::optional<core::LoadCase> common_;
    std::unique_ptr<core::PreparedModel> prepared_;
};

} // namespace

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

core::Model cached(const core::Model &model, const SolutionCache &cache) {
    auto found_or_solved = model;
    found_or_solved.prepare = [model, cache](const std::shared_ptr<const core::Body> &body,
                                             const core::LoadCase *common) {
        return std::make_unique<PreparedWithCache>(model, cache, body, common);
    };
    return found_or_solved;
}

std::filesystem::path folder_of_solutions(const std::filesystem::path &output, const std::string &settings) {
    support::FnvHash hash;
    hash.add(settings);
    return output / solutions_folder / fmt::format("{:016x}", hash.value());
}

} // namespace livermark::studies
