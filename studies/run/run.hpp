#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/model.hpp"
#include "core/problem.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/models/model_table.hpp"
#include "studies/study.hpp"

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
    SolutionCache cache_;
    std::vector<core::Problem> common_;
    std::shared_ptr<const core::Body> body_;
    std::map<std::string, std::unique_ptr<core::PreparedModel>> prepared_;
};

} // namespace livermark::studies

namespace livermark::studies {

/// A load case that does not fit a body.
struct LeftOut {
    std::string body, load_case;
    std::string reason; ///< a clause
    load_cases::LoadCaseKind kind;
};

/// Problems that were read, and what their user should know of them.
struct ProblemSet {
    std::vector<core::Problem> problems;
    std::vector<std::string> notes; ///< a sentence each: what had to be assumed
    std::vector<LeftOut> left_out;
};

/// Load cases that do not fit a body for the same reason, as one entry with their names in load_case.
std::vector<LeftOut> grouped(const std::vector<LeftOut> &left_out);

/// A sentence for each place that lost a part of its area, see core::LoadCase::yielded.
std::vector<std::string> yielded_places(std::span<const core::Problem> problems);

/// A sentence for each group.
std::vector<std::string> sentences(const std::vector<LeftOut> &left_out);

/// Reads every body once and puts every load case on it, so that a fault shows before the first hour of work.
///
/// A load case that does not fit a body (see load_cases::NotOnBody) is left out there, and the others are read. It is
/// refused where it is a file of the user's own and the body was asked for by name, unless it may be left out as well.
/// @param bodies      names or paths of what was asked for; all that ship if there are none
/// @param load_cases  the same
/// @return body by body, loads as they are written
/// @throws support::InputError for a fault of any file, if no load case fits any body, and for a moving tool
ProblemSet read_problems(const std::vector<std::string> &bodies, const std::vector<std::string> &load_cases,
                         const meshes::MaterialOverride &material, bool may_leave_out = false);

/// The same of one load case in which a tool moves, which read_problems() refuses.
/// @param load_case  path
ProblemSet read_moving_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                const meshes::MaterialOverride &material);

/// The same of one load case with a needle, which read_problems() refuses.
/// @param load_case  path
ProblemSet read_needle_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                const meshes::MaterialOverride &material);

/// The same for a command of one rank and one load case, with the loads scaled to their target where it asks for that.
/// Places that yielded and what is left out are in the notes.
ProblemSet read_scaled_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                const meshes::MaterialOverride &material);

/// The load case that gives the constraints where none is named.
inline constexpr const char *usual_constraints = "traction";

/// The same for a command that takes constraints from a load case. Where none is named, a body that was asked for by
/// name has those of usual_constraints, or where that does not fit, of the first load case that ships and fits; the
/// notes say which.
/// @param load_case  name or path; empty where none is named
ProblemSet read_constrained_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                     const meshes::MaterialOverride &material);

/// Multiplies what drives a problem until the linear baseline reaches the target of its load case, where that asks for
/// it (LoadCase::scale_to_target), within 5e-6; the factor, of six digits, goes into LoadCase::load_scale.
/// @param baseline  linear; if it is collective all MPI ranks have to call this
/// @param prepared  what the baseline solves with
/// @return with scale_to_target off, so that nobody scales twice
/// @throws std::runtime_error if the baseline finds no solution, or one that does not move
core::Problem scaled_to_target(core::Problem problem, const core::Model &baseline, PreparedModels &prepared);

/// The same by the baseline of the model table, for commands of one rank.
/// @throws support::InputError on several MPI ranks, where the baseline would wait for the others
core::Problem scaled_to_target(core::Problem problem);

/// The problem at multiples of its load, as load cases "<name>@<amplitude>"; just itself if there are no amplitudes.
/// @param amplitudes  > 0
std::vector<core::Problem> at_amplitudes(const core::Problem &problem, std::span<const double> amplitudes);

/// Numbers of problems of one body with the same static solution, which models keep: one worker takes them one after
/// the other, so that what is kept does not depend on how many workers there are.
using CaseGroup = std::vector<std::size_t>;

/// Groups of all problems. Those that constrain the same components of a body come one after the other: models keep the
/// last factor. Bodies come by their number of tetrahedra, the largest first: it would keep the others waiting at the
/// end. What comes first otherwise stays first.
std::vector<CaseGroup> case_groups_of(std::span<const core::Problem> problems);

/// Problems whose factor others share: of each body with load cases that constrain all that another one constrains and
/// more, the first problem whose constrained components are constrained in most of them.
std::vector<core::Problem> most_shared(std::span<const core::Problem> problems);

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
