#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/model.hpp"

namespace livermark::studies {

/// Solutions that need not be solved again. There are two folders of them: that of the references that ship, which is
/// only read, and that of a run, where its workers leave their solutions for each other, and for a run that goes on
/// after this one was killed. A solution is found by model, load case, mesh, materials and conditions; a folder of a
/// run is for one choice of settings.
class SolutionCache {
  public:
    /// Has nothing.
    SolutionCache() = default;

    /// @param references  of files as results::reference_path() says
    explicit SolutionCache(std::filesystem::path references) : references_(std::move(references)) {}

    /// The references that ship.
    static SolutionCache shipped();

    /// Keeps solutions from now on, below the output folder of a run, by all that they depend on beside the problem.
    /// @param settings  such as the command and the version of the program
    void keep_in(const std::filesystem::path &output, const std::string &settings);

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

/// The folder of references that were solved before, below the root.
std::filesystem::path stored_references_folder();

/// Whether the solution of a model to a problem is solved once and stored: those on finer meshes, those that judge
/// large deformations, and of load cases with a release the one that judges large motions, and those that tell how good
/// the motion is that judges.
bool is_stored(const core::Model &model, const core::Problem &problem);

/// Lets models that tell how good the motion is that judges take part only where their solution is stored.
void leave_out_unsolved_motions(std::vector<core::Model> &models);

/// Outcome of `livermark reference` for a model and a problem.
struct StoredSolution {
    std::filesystem::path file;
    core::SolutionStatus status;
    std::string message;              ///< why the status is not ok
    double difference = 0.0;          ///< of the displacement from what was stored, relative; NaN if there was none
    double reaction_difference = 0.0; ///< the same of the reactions
    double motion_difference = 0.0;   ///< the same of the probes in time; NaN if there was none, or nothing moves
};

/// Solves, and writes the solution unless it is only to be checked.
/// @throws support::InputError if the file cannot be written
StoredSolution solve_and_store(const core::Model &model, const core::Problem &problem,
                               const std::filesystem::path &folder, bool only_check, const std::string &command_line);

/// The models whose solutions are stored, of some problems at least: see is_stored().
std::vector<core::Model> models_to_keep();

/// Models on the body that is being worked on. A model solves what a cache does not have, and leaves it there; what it
/// prepares for that stays for other load cases, by its name. That of the body before goes first, so that there is
/// room. For one thread.
class PreparedModels {
  public:
    PreparedModels() = default;

    /// @param common  of bodies, see core::PrepareModel: those of most_shared()
    explicit PreparedModels(SolutionCache cache, std::vector<core::Problem> common = {})
        : cache_(std::move(cache)), common_(std::move(common)) {}

    core::Solution solve(const core::Model &model, const core::Problem &problem);

    /// @param problems  of one body, at least one
    std::vector<core::Solution> solve(const core::Model &model, std::span<const core::Problem> problems);

    /// Makes room.
    void clear();

  private:
    core::PreparedModel &prepared(const core::Model &model);
    void keep(const core::Model &model, const core::Problem &problem, const core::Solution &solution) const;

    SolutionCache cache_;
    std::vector<core::Problem> common_;
    std::shared_ptr<const core::Body> body_;
    std::map<std::string, std::unique_ptr<core::PreparedModel>> prepared_;
};

} // namespace livermark::studies
