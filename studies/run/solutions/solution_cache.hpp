#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "core/model.hpp"

namespace livermark::studies {

/// Solutions that need not be solved again. There are two folders of them: that of the references that ship, which is
/// only read, and that of a run, where its workers leave what they have solved, for each other and for a run that goes
/// on after this one was killed. A solution is found by model, load case, mesh, materials and conditions; a folder of a
/// run is for one choice of settings.
class SolutionCache {
  public:
    /// Has nothing.
    SolutionCache() = default;

    /// @param references  of files as results::reference_path() says
    explicit SolutionCache(std::filesystem::path references) : references_(std::move(references)) {}

    /// Keeps solutions in a folder from now on.
    /// @param folder  of a run; it need not be there
    void keep_in(std::filesystem::path folder) { folder_ = std::move(folder); }

    /// @return "kept" if the run has the solution, "stored" if it is a reference that ships; else empty
    std::string where(const core::Model &model, const core::Problem &problem) const;

    /// @return nothing if there is none, or a damaged one in the folder of the run
    /// @throws support::InputError if the file of a reference is damaged
    std::optional<core::Solution> find(const core::Model &model, const core::Problem &problem) const;

    /// Does nothing without a folder of a run.
    /// @throws support::InputError if it cannot be written to
    void keep(const core::Model &model, const core::Problem &problem, const core::Solution &solution) const;

    /// Takes the solutions of a problem out of the folder of the run: a result file has them.
    void forget(std::span<const core::Model> models, const core::Problem &problem) const;

    /// Takes all of them out.
    void clear() const;

  private:
    std::filesystem::path file(const core::Model &model, const core::Problem &problem) const;
    /// Empty if no reference of the problem ships.
    std::filesystem::path stored_file(const core::Model &model, const core::Problem &problem) const;

    std::filesystem::path references_, folder_;
};

/// The same model, which prepares and solves only what the cache does not have, and leaves there what it has solved.
core::Model cached(const core::Model &model, const SolutionCache &cache);

/// Where the solutions of a run are kept: below its output folder, by all that they depend on beside the problem.
/// @param settings  such as the command and the version of the program
std::filesystem::path folder_of_solutions(const std::filesystem::path &output, const std::string &settings);

} // namespace livermark::studies
