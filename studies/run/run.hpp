#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/model.hpp"
#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/models/model_table.hpp"
#include "studies/run/problems.hpp"
#include "studies/run/solutions.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

/// The models asked for by name, with what judges them beside them, in the order of the table: the reference, the
/// refined reference, and those of motion where something moves. All if none was asked for.
/// @param with_uncertainty  if not, the refined reference runs only if it was asked for by name
/// @throws support::InputError for a name that there is not, with the nearest one that there is
std::vector<core::Model> choose_models(const std::vector<std::string> &wanted, const models::ModelOptions &options,
                                       bool with_uncertainty);

/// The one that scales loads, of all models.
const core::Model &baseline_of(const std::vector<core::Model> &models);

/// Whether it is a result like others that a model finds no solution: in the large regime, unless it is a reference.
bool may_fail(const std::string &model, core::Regime regime);

/// Finds the solution of a model to a problem, or has it already.
using SolveModel = std::function<core::Solution(const core::Model &, const core::Problem &)>;

/// Lets every model solve a problem and compares it with the reference: with the refined one if that was solved and the
/// other is not good enough, see results::estimate_uncertainty(). A model that finds no solution is part of the result;
/// where the reference finds none, nothing is compared.
/// Of several MPI ranks all call this; the collective models run on all of them and first, so that no failure of
/// another model leaves a rank waiting. The others run on rank 0, which alone compares.
/// @param solve  called for each model that runs on this rank
results::Result evaluate(const core::Problem &problem, const std::vector<core::Model> &models, const SolveModel &solve,
                         results::Provenance provenance);

/// A model that is farther than this from its own linearised solution is not to be compared with linear elasticity.
inline constexpr double fair_nonlinearity = 0.05;

/// The amplitudes at which linear elasticity is a fair reference: a row for each body, load case and non-linear model,
/// its distance from its own linearised solution [%] in a column for each amplitude, and the amplitude up to which all
/// are below fair_nonlinearity.
/// @param results     of problems from at_amplitudes(), those that failed missing
/// @param amplitudes  ascending
results::Layout nonlinearity_by_amplitude(std::span<const results::Result> results, std::span<const double> amplitudes);

/// Work that a worker does in one go, as support::run_in_process_pool() hands it out: models solve problems of one
/// body, or the benchmark case of one problem is evaluated.
struct WorkItem {
    std::vector<std::size_t> models;    ///< numbers of those that solve; none in a benchmark case
    std::vector<CaseGroup> case_groups; ///< to solve; in a benchmark case a single problem
    int group;                          ///< of items that share something that models keep
    std::vector<int> waits_for{};       ///< items before it that it needs

    bool is_evaluation() const { return models.empty(); }
    std::size_t first_problem() const { return case_groups.front().front(); }
};

/// Items of a run: of each body first the solutions, model by model, then the benchmark cases, which find theirs there.
/// Models that solve problems together share a group, and each of the others has its own, so that no worker makes
/// factors that another one has, or keeps those of all models.
/// @param models     those that solve before the benchmark cases
/// @param is_wanted  whether a problem has no result yet; what is solved together does not depend on it, but for what
///   has a result
std::vector<WorkItem> plan_work(std::span<const core::Problem> problems, std::span<const core::Model> models,
                                const std::function<bool(std::size_t)> &is_wanted);

/// A run is three values: the options of its user, the run that they come to, and its outcome. Workers and this process
/// have the cache of solutions and the result files between them, and lines of progress.

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
/// that runs out of memory, has failed; the others go on. Of several MPI ranks all call this, and the first one alone
/// compares and writes.
/// @param command_line  kept in the result files
/// @throws support::InputError if a result cannot be kept
RunOutcome run_cases(const Run &run, const std::string &command_line, const ProgressReport &report);

} // namespace livermark::studies
