#include "studies/run/run_task.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <memory>
#include <optional>
#include <string>

#include "results/hdf5/calibration_file.hpp"
#include "studies/run/benchmark_case.hpp"
#include "studies/run/kept_references.hpp"
#include "studies/run/output_folder.hpp"
#include "studies/run/problems.hpp"
#include "support/input_error.hpp"
#include "support/mpi_session.hpp"
#include "support/root_folder.hpp"

namespace livermark::studies {

namespace {

/// Error bands hold for the bodies as they ship, not for other materials, and against the reference that is chosen
/// when its uncertainty is known.
results::ErrorBands read_bands(const RunOptions &options) {
    if (options.young_modulus || !options.poisson_ratios.empty() || options.no_uncertainty)
        return {};
    return results::read_error_bands(support::root_folder() / "results" / "error_bands.toml");
}

models::ModelOptions model_options(const RunOptions &options) {
    auto chosen = options.model_options;
    constexpr auto *calibrated = "calibrated_nodal_volume";
    if (options.calibration.empty() && std::ranges::find(options.models, calibrated) != options.models.end())
        throw support::InputError(
            fmt::format("model {} takes its springs from a file; name it with --calibration, or make "
                        "one with `livermark calibrate`",
                        calibrated));
    if (!options.calibration.empty())
        chosen.calibration =
            std::make_shared<const core::CalibratedSprings>(results::read_calibration(options.calibration).springs);
    return chosen;
}

ProblemSet read_all_problems(const RunOptions &options) {
    if (options.poisson_ratios.empty())
        return read_problems(options.bodies, options.load_cases, {options.young_modulus, {}});
    ProblemSet all;
    for (const double poisson_ratio : options.poisson_ratios) {
        auto some = read_problems(options.bodies, options.load_cases, {options.young_modulus, poisson_ratio});
        std::ranges::move(some.problems, std::back_inserter(all.problems));
        if (all.notes.empty()) // they are the same for every Poisson's ratio
            all.notes = std::move(some.notes);
    }
    return all;
}

RunTask prepare_on_this_rank(const RunOptions &options) {
    if (support::mpi_num_ranks() > 1 && options.resume)
        throw support::InputError("--resume works on one rank only; leave it out or start without mpirun");
    if (support::mpi_num_ranks() > 1 && options.model_options.fem_solver == fem_reference::SolverChoice::direct)
        throw support::InputError("--fem-solver direct works on one rank only; leave it out or start without mpirun");
    if (support::mpi_num_ranks() > 1 && options.jobs.value_or(1) > 1)
        throw support::InputError("--jobs works on one rank only; leave it out or start without mpirun");
    RunTask task{
        choose_models(options.models, model_options(options), !options.no_uncertainty), {}, read_bands(options), {}};
    auto read = read_all_problems(options);
    task.problems = std::move(read.problems);
    task.notes = std::move(read.notes);
    if (options.load_cases.empty())
        std::erase_if(task.problems, [&](const core::Problem &problem) {
            return std::ranges::find(options.regimes, problem.load_case.regime) == options.regimes.end();
        });
    if (options.only_static)
        std::erase_if(task.problems,
                      [](const core::Problem &problem) { return problem.load_case.release.has_value(); });
    if (!options.solve_reference)
        use_kept_references(task.models, kept_references_folder());
    if (support::mpi_rank() == 0) {
        for (const auto &problem : task.problems)
            for (const auto &model : task.models)
                if (model.check)
                    model.check(problem);
        for (const auto &problem : task.problems)
            make_output_folder(output_folder(options, problem), problem);
    }
    return task;
}

} // namespace

std::filesystem::path output_folder(const RunOptions &options, const core::Problem &problem) {
    return options.poisson_ratios.empty()
               ? std::filesystem::path(options.output)
               : std::filesystem::path(options.output) /
                     fmt::format("poisson_{:g}", problem.body->materials.front().poisson_ratio);
}

// A fault of one rank, say a file that only one machine has, is a fault of all: none may go on alone.
RunTask prepare(const RunOptions &options) {
    std::optional<RunTask> task;
    std::string fault;
    try {
        task = prepare_on_this_rank(options);
    } catch (const support::InputError &error) {
        fault = error.what();
    }
    fault = support::first_text_of_ranks(fault);
    if (!fault.empty())
        throw support::InputError(fault);
    return std::move(*task);
}

} // namespace livermark::studies
