#pragma once

#include <filesystem>
#include <vector>

#include "core/problem.hpp"
#include "models/model_table.hpp"
#include "studies/run/problems.hpp"
#include "studies/run/run_options.hpp"
#include "studies/run/solutions/solution_cache.hpp"

namespace livermark::studies {

/// What the options of a run come to.
struct RunTask {
    std::vector<core::Model> models;
    std::vector<core::Problem> problems;
    std::vector<std::string> notes; ///< what a user should know of the input, a sentence each
    std::vector<LeftOut> left_out;
    SolutionCache solutions; ///< references that are stored, if they may be used
    core::Model baseline;    ///< what scales loads, whether it was asked for or not
};

/// Reads and checks all that a user may have got wrong, on this MPI rank alone, and writes nothing.
/// @throws support::InputError as prepare()
RunTask read_task(const RunOptions &options);

/// The same on all MPI ranks, and makes the output folders.
/// @throws support::InputError on all MPI ranks, if it has a fault on one of them, and if no load case that is asked
/// for
///         fits a body
RunTask prepare(const RunOptions &options);

/// Bodies of another Poisson's ratio have a folder of their own, and leave the files of the others alone.
std::filesystem::path output_folder(const RunOptions &options, const core::Problem &problem);

} // namespace livermark::studies
