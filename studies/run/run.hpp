#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "results/records/result.hpp"
#include "studies/models/model_table.hpp"
#include "studies/progress.hpp"
#include "studies/run/problems.hpp"
#include "studies/run/solutions.hpp"

/// A run is three values: the options of its user, the run that they come to, and its outcome. Workers and this process
/// have the cache of solutions and the result files between them, and lines of progress.
namespace livermark::studies {

/// Options of `livermark run`.
struct RunOptions {
    std::vector<std::string> bodies;
    std::vector<std::string> load_cases;
    std::vector<core::Regime> regimes{core::Regime::small}; ///< where load cases are not asked for by name
    bool has_asked_for_regime = false; ///< then load cases that are asked for by name have to be of these regimes
    std::vector<std::string> models;
    std::vector<double> amplitudes; ///< of the loads; as they are if there are none
    std::optional<double> young_modulus;
    std::vector<double> poisson_ratios; ///< of every region; as the bodies say if there are none
    std::string calibration;            ///< a file; none if empty
    std::string output;
    bool reference_on_mesh = false;
    bool solve_reference = false; ///< also where a solution is stored
    bool only_static = false;
    bool resume = false;
    bool may_leave_out = false; ///< also load case files of the user's own that do not fit a body
    std::optional<int> jobs; ///< load cases side by side, >= 1; as many as there are cores and memory for if not given
    models::ModelOptions model_options;
};

/// Models and problems that the options come to.
struct Run {
    RunOptions options;
    std::vector<core::Model> models;
    core::Model baseline; ///< scales loads, whether it was asked for or not
    std::vector<core::Problem> problems{};
    std::vector<std::string> notes{}; ///< a sentence each on the input, for its user
    std::vector<LeftOut> left_out{};
    SolutionCache solutions{}; ///< references that are stored, if they may be used

    /// <output>/<body>/<load case>.h5. Bodies of another Poisson's ratio have a folder of their own,
    /// <output>/poisson_*, and leave the files of the others alone.
    std::filesystem::path result_file(const core::Problem &problem) const;
};

/// Results and failures of a run, in the order of its problems and then of the amplitudes.
struct RunOutcome {
    std::vector<results::Result> done;
    std::vector<std::string> failures; ///< a sentence each
    int num_kept = 0;                  ///< of those done, that were there already
    TimeSpent spent;                   ///< by all workers together
    std::vector<std::string> notes;    ///< a sentence for each worker that was lost where nothing failed by it
};

/// Reads and checks all that a user may have got wrong, on this MPI rank alone, and writes nothing.
/// @throws support::InputError as prepare()
Run read_run(const RunOptions &options);

/// The same on all MPI ranks, and makes sure of the output folders.
/// @throws support::InputError on all MPI ranks, if it has a fault on one of them, and if no load case that is asked
///   for fits a body
Run prepare(const RunOptions &options);

/// Evaluates the benchmark cases of a run, after what models solve together: in several processes where cores and
/// memory allow and the options do not say otherwise, and writes each to its file as soon as it is done. The numbers do
/// not depend on how many processes there are. A case whose process is killed, as happens where the memory ends, or
/// that runs out of memory, has failed; the others go on.
/// @param command_line  kept in the result files
/// @throws support::InputError if a result cannot be kept
RunOutcome run_cases(const Run &run, const std::string &command_line, const ProgressReport &report);

/// The part of the MPI ranks that neither compare nor write. Faults here are faults on rank 0 as well, which says so.
void help_first_rank(const Run &run, const std::string &command_line);

} // namespace livermark::studies
