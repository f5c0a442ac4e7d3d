#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "studies/run/prepared_models.hpp"
#include "studies/run/work/run_task.hpp"
#include "studies/run/work/work_plan.hpp"
#include "support/processes/process_pool.hpp"

namespace livermark::studies {

/// What all workers of a run know.
struct Run {
    RunTask task; ///< its models have the cache of the run
    const RunOptions &options;
    const std::string &command_line;
    std::vector<core::Problem> problems{}; ///< at their targets and amplitudes
    bool solves_first = true;              ///< not on several MPI ranks, which solve each benchmark case together
    WorkPlan plan{};
};

/// What each worker has of its own.
struct Worker {
    PreparedModels prepared;
    int at_group = -1; ///< of the item before
};

/// <output>/<body>/<load case>.h5
std::filesystem::path result_file_of(const core::Problem &problem, const RunOptions &options);

/// Does an item of the plan: lets models solve, whose solutions the cache keeps, or evaluates the benchmark case of a
/// problem and writes its result. What finds no solution in the first stage has none: the benchmark case tries again,
/// and says so.
/// @throws support::InputError on one rank, if the result cannot be written
void do_item(const Run &run, int item, Worker &worker, const support::SendMessage &send);

/// The steps that it is reported in.
int num_steps(const Run &run);

} // namespace livermark::studies
