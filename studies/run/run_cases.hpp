#pragma once

#include <string>
#include <vector>

#include "results/records/result.hpp"
#include "studies/progress.hpp"
#include "studies/run/work/run_task.hpp"
#include "studies/run/work/time_spent.hpp"

namespace livermark::studies {

/// What became of one problem, at all amplitudes.
struct Outcome {
    std::vector<results::Result> done;
    std::vector<std::string> failures; ///< a sentence each
    int num_kept = 0;                  ///< of those done, that were there already
};

/// What became of all.
struct Outcomes {
    std::vector<Outcome> of_problem; ///< (P) in the order of the problems
    TimeSpent spent;                 ///< by all workers together
    std::vector<std::string> notes;  ///< a sentence for each worker that was lost where nothing failed by it
};

/// Evaluates the benchmark cases of a run, after what models solve together: in several processes where cores and
/// memory allow and the options do not say otherwise, and writes each to its file as soon as it is done. The numbers do
/// not depend on how many processes there are. A case whose process is killed, as happens where the memory ends, or
/// that runs out of memory, has failed; the others go on.
/// @param command_line  kept in the result files
/// @throws support::InputError if a result cannot be kept
Outcomes run_cases(const RunTask &task, const RunOptions &options, const std::string &command_line,
                   const ProgressReport &report);

/// The part of the MPI ranks that neither compare nor write. What fails here fails on rank 0 as well, which says so.
void help_first_rank(const RunTask &task, const RunOptions &options, const std::string &command_line);

} // namespace livermark::studies
