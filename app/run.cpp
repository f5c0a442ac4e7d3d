#include "app/run_options.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>

#include "app/amplitudes.hpp"
#include "app/catalogue.hpp"
#include "app/contest.hpp"
#include "app/load_scaling.hpp"
#include "app/output.hpp"
#include "app/problems.hpp"
#include "app/progress.hpp"
#include "app/run_tables.hpp"
#include "app/time_spent.hpp"
#include "core/input_error.hpp"
#include "core/root_folder.hpp"
#include "fem_reference/mpi_session.hpp"
#include "meshes/body_reader.hpp"
#include "results/calibration_file.hpp"
#include "results/error_bands.hpp"
#include "results/kept_result.hpp"
#include "results/provenance.hpp"
#include "results/result_file.hpp"
#include "results/table_layout.hpp"

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

bool all_is_well(const results::Result &result) {
    return std::ranges::all_of(result.models, [](const results::ModelResult &model) {
        return model.solution.status == core::SolutionStatus::ok && results::meets_band(model).value_or(true);
    });
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

/// Bodies of another Poisson's ratio have a folder of their own, and leave the files of the others alone.
std::filesystem::path output_folder(const RunOptions &options, const core::Problem &problem) {
    return options.poisson_ratios.empty()
               ? std::filesystem::path(options.output)
               : std::filesystem::path(options.output) /
                     fmt::format("poisson_{:g}", problem.body->materials.front().poisson_ratio);
}

/// All that a user may have got wrong.
struct Task {
    std::vector<core::Model> models;
    std::vector<core::Problem> problems;
    results::ErrorBands bands;
};

Task prepare(const RunOptions &options) {
    if (fem_reference::mpi_num_ranks() > 1 && options.resume)
        throw core::InputError("--resume works on one rank only; leave it out or start without mpirun");
    if (fem_reference::mpi_num_ranks() > 1 && options.model_options.fem_solver == fem_reference::SolverChoice::direct)
        throw core::InputError("--fem-solver direct works on one rank only; leave it out or start without mpirun");
    Task task{choose_models(options.models, model_options(options), !options.no_uncertainty),
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

/// A fault of one rank, say a file that only one machine has, is a fault of all: none may go on alone.
Task prepare_on_all_ranks(const RunOptions &options) {
    std::optional<Task> task;
    std::string fault;
    try {
        task = prepare(options);
    } catch (const core::InputError &error) {
        fault = error.what();
    }
    fault = fem_reference::first_text_of_ranks(fault);
    if (!fault.empty())
        throw core::InputError(fault);
    return std::move(*task);
}

/// Every choice of models has the baseline.
const core::Model &baseline_of(const Task &task) {
    return *std::ranges::find(task.models, models::baseline_model, &core::Model::name);
}

using Contest = std::function<void(const core::Problem &)>;

/// Holds one contest for each problem and amplitude, in the same order on all ranks: what is collective in it would
/// wait for ever otherwise, so a failure of one keeps nobody from the next.
/// @throws core::InputError on one rank, if a result cannot be kept
void for_each_contest(const Task &task, const RunOptions &options, const Contest &hold,
                      const std::function<void(const core::Problem &, const char *)> &failed) {
    const auto guarded = [&](const core::Problem &problem, const Contest &action) {
        try {
            action(problem);
        } catch (const core::InputError &error) {
            // All else was checked before: results have no place any more. Other ranks would wait for this one.
            if (fem_reference::mpi_num_ranks() == 1)
                throw;
            failed(problem, error.what());
        } catch (const std::exception &error) {
            failed(problem, error.what());
        }
    };
    for (const auto &problem : task.problems)
        guarded(problem, [&](const core::Problem &as_read) {
            for (const auto &loaded : at_amplitudes(scaled_to_target(as_read, baseline_of(task)), options.amplitudes))
                guarded(loaded, hold);
        });
}

/// The part of the ranks that neither compare nor write. What fails here fails on rank 0 as well, which says so.
int help_first_rank(const Task &task, const RunOptions &options, const std::string &command_line) {
    for_each_contest(
        task, options,
        [&](const core::Problem &problem) {
            hold_contest(problem, task.models, task.bands, results::current_provenance(command_line),
                         [](const auto &) {});
        },
        [](const auto &, const char *) {});
    return 0;
}

void keep(const std::filesystem::path &file, const results::Result &result) {
    try {
        results::write_result(file, result);
    } catch (const core::InputError &error) {
        throw core::InputError(fmt::format("{}, and go on with --resume", error.what()));
    }
}

std::string name_of(const core::Problem &problem) {
    return fmt::format("{} / {}", problem.body->name, problem.load_case.name);
}

void print_all(const std::vector<results::Result> &done, const RunOptions &options) {
    print_tables(done, TableKind::all, options.markdown);
    if (!options.amplitudes.empty()) {
        const auto layout = nonlinearity_by_amplitude(done, options.amplitudes);
        fmt::print("\nDistance of models from their own linearised answer, at multiples of the load:\n\n{}",
                   options.markdown ? results::to_markdown(layout) : results::to_text(layout));
    }
}

} // namespace

int run(const RunOptions &options, const std::string &command_line) {
    constexpr auto *other_work = "bodies, loads, comparisons, files";
    TimeSpent spent;
    spent.begin(other_work);
    const auto task = prepare_on_all_ranks(options);
    if (fem_reference::mpi_rank() != 0)
        return help_first_rank(task, options, command_line);

    std::vector<results::Result> done;
    std::vector<std::string> failures;
    {
        const auto num_contests = task.problems.size() * std::max<std::size_t>(1, options.amplitudes.size());
        Progress progress(static_cast<int>(num_contests * task.models.size()));
        for_each_contest(
            task, options,
            [&](const core::Problem &problem) {
                const auto file =
                    make_output_folder(output_folder(options, problem), problem) / (problem.load_case.name + ".h5");
                const auto provenance = results::current_provenance(command_line);
                if (options.resume)
                    if (auto kept = results::kept_result(file, problem, provenance)) {
                        for (const auto &model : task.models)
                            progress.next(fmt::format("{} / {}, kept", name_of(problem), model.name));
                        done.push_back(std::move(*kept));
                        return;
                    }
                const auto result = hold_contest(problem, task.models, task.bands, provenance, [&](const auto &model) {
                    progress.next(fmt::format("{} / {}", name_of(problem), model));
                    spent.begin(model);
                });
                spent.begin(other_work);
                keep(file, result);
                done.push_back(result);
            },
            [&](const core::Problem &problem, const char *reason) {
                spent.begin(other_work);
                failures.push_back(fmt::format("{}: {}", name_of(problem), reason));
            });
    }
    print_all(done, options);
    fmt::print(stderr, "\n{}\n", spent.text());
    for (const auto &failure : failures)
        fmt::print(stderr, "livermark: failed: {}\n", failure);
    fmt::print(stderr, "Result files are in {}\n", options.output);
    return failures.empty() && std::ranges::all_of(done, all_is_well) ? 0 : 1;
}

} // namespace livermark::app
