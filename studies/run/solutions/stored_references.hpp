#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/model.hpp"

namespace livermark::studies {

/// Where references that were solved before are stored, below the root.
std::filesystem::path stored_references_folder();

/// Whether the solution of a model to a problem is solved once and stored: those on finer meshes, those that judge
/// large deformations, and of load cases with a release the one that judges large motions, and those that tell how good
/// the motion is that judges.
bool is_stored(const core::Model &model, const core::Problem &problem);

/// Lets those that tell how good the motion is that judges take part only where their solution is stored.
/// @param folder  of reference files, see results::reference_path()
void leave_out_unsolved_motions(std::vector<core::Model> &models, const std::filesystem::path &folder);

/// The same, and reads the solutions that are stored where a file fits model, mesh, materials, conditions and path; all
/// others are solved as ever.
void use_stored_references(std::vector<core::Model> &models, const std::filesystem::path &folder);

/// What `livermark reference` does with each model and problem.
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

} // namespace livermark::studies
