#include "app/run_task.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <memory>
#include <optional>
#include <string>

#include "app/contest.hpp"
#include "app/output.hpp"
#include "app/problems.hpp"
#include "core/input_error.hpp"
#include "core/root_folder.hpp"
#include "fem_reference/mpi_session.hpp"
#include "results/calibration_file.hpp"

namespace livermark::app {

namespace {

/// Error bands hold for the bodies as they ship, not for other materials, and against the reference that is chosen
/// when its uncertainty is known.
results::ErrorBands read_bands(const RunOptions &options) {
    if (options.young_modulus || !options.poisson_ratios.empty() || options.no_uncertainty)
        return {};
    return results::read_error_bands(core::root_folder() / "results" / "error_bands.toml");
}

models::ModelOptions model_options(const RunOptions &options) {
    auto chosen = options.model_options;
    constexpr auto *calibrated = "calibrated_nodal_volume";
    if (options.calibration.empty() && std::ranges::find(options.models, calibrated) != options.models.end())
        throw core::InputError(
            fmt::format("model {} takes its springs from a file; name it with --calibration, or make "
                        "one with `livermark calibrate`",
                        calibrated));
    if (!options.calibration.empty())
        chosen.calibration =
            std::make_shared<const core::CalibratedSprings>(results::read_calibration(options.calibration).springs);
    return chosen;
}

std::vector<core::Problem> read_all_problems(const RunOptions &options) {
    if (options.poisson_ratios.empty())
        return read_problems(options.bodies, options.load_cases, {options.young_modulus, {}});
    std::vector<core::Problem> problems;
    for (const double poisson_ratio : options.poisson_ratios)
        std::ranges::move(read_problems(options.bodies, options.load_cases, {options.young_modulus, poisson_ratio}),
                          std::back_inserter(problems));
    return problems;
}

RunTask prepare_on_this_rank(const RunOptions &options) {
    if (fem_reference::mpi_num_ranks() > 1 && options.resume)
        throw core::InputError("--resume works on one rank only; leave it out or start without mpirun");
    if (fem_reference::mpi_num_ranks() > 1 && options.model_options.fem_solver == fem_reference::SolverChoice::direct)
        throw core::InputError("--fem-solver direct works on one rank only; leave it out or start without mpirun");
    if (fem_reference::mpi_num_ranks() > 1 && options.jobs.value_or(1) > 1)
        throw core::InputError("--jobs works on one rank only; leave it out or start without mpirun");
    RunTask task{choose_models(options.models, model_options(options), !options.no_uncertainty),
                 read_all_problems(options), read_bands(options)};
    if (options.only_static)
        std::erase_if(task.problems,
                      [](const core::Problem &problem) { return problem.load_case.release.has_value(); });
    if (fem_reference::mpi_rank() == 0) {
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
    } catch (const core::InputError &error) {
        fault = error.what();
    }
    fault = fem_reference::first_text_of_ranks(fault);
    if (!fault.empty())
        throw core::InputError(fault);
    return std::move(*task);
}

} // namespace livermark::app
