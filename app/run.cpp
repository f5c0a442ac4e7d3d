#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <optional>

#include "app/amplitudes.hpp"
#include "app/catalogue.hpp"
#include "app/commands.hpp"
#include "app/contest.hpp"
#include "app/load_scaling.hpp"
#include "app/output.hpp"
#include "app/problems.hpp"
#include "app/progress.hpp"
#include "app/run_tables.hpp"
#include "core/input_error.hpp"
#include "fem_reference/mpi_session.hpp"
#include "meshes/body_reader.hpp"
#include "results/calibration_file.hpp"
#include "results/error_bands.hpp"
#include "results/provenance.hpp"
#include "results/result_file.hpp"
#include "results/table_layout.hpp"

namespace livermark::app {

namespace {

struct RunOptions {
    std::vector<std::string> bodies;
    std::vector<std::string> load_cases;
    std::vector<std::string> models;
    std::vector<double> amplitudes; ///< of the loads; as they are if there are none
    std::optional<double> young_modulus;
    std::vector<double> poisson_ratios; ///< of every region; as the bodies say if there are none
    std::string calibration; ///< a file; none if empty
    std::string output;
    bool markdown = false;
    bool no_uncertainty = false;
    bool only_static = false;
    models::ModelOptions model_options;
};

/// Error bands hold for the bodies as they ship, not for other materials, and against the reference that is chosen
/// when its uncertainty is known.
results::ErrorBands read_bands(const RunOptions &options) {
    if (options.young_modulus || !options.poisson_ratios.empty() || options.no_uncertainty)
        return {};
    return results::read_error_bands(root_folder() / "results" / "error_bands.toml");
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
        std::ranges::move(
            read_problems(options.bodies, options.load_cases, {options.young_modulus, poisson_ratio}),
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
    if (fem_reference::mpi_num_ranks() > 1 && options.model_options.fem_solver == fem_reference::SolverChoice::direct)
        throw core::InputError("--fem-solver direct works on one rank only; leave it out or start without mpirun");
    Task task{choose_models(options.models, model_options(options), !options.no_uncertainty),
              read_all_problems(options), read_bands(options)};
    if (options.only_static)
        std::erase_if(task.problems,
                      [](const core::Problem &problem) { return problem.load_case.release.has_value(); });
    if (fem_reference::mpi_rank() == 0)
        for (const auto &problem : task.problems) {
            for (const auto &model : task.models)
                if (model.check)
                    model.check(problem);
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
void for_each_contest(const Task &task, const RunOptions &options, const Contest &hold,
                      const std::function<void(const core::Problem &, const char *)> &failed) {
    const auto guarded = [&](const core::Problem &problem, const Contest &action) {
        try {
            action(problem);
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

int run(const RunOptions &options, const std::string &command_line) {
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
                const auto result = hold_contest(
                    problem, task.models, task.bands, results::current_provenance(command_line),
                    [&](const auto &model) { progress.next(fmt::format("{} / {}", name_of(problem), model)); });
                const auto file = make_output_folder(output_folder(options, problem), problem) / (problem.load_case.name + ".h5");
                results::write_result(file, result);
                done.push_back(result);
            },
            [&](const core::Problem &problem, const char *reason) {
                failures.push_back(fmt::format("{}: {}", name_of(problem), reason));
            });
    }
    print_all(done, options);
    for (const auto &failure : failures)
        fmt::print(stderr, "livermark: failed: {}\n", failure);
    fmt::print(stderr, "Result files are in {}\n", options.output);
    return failures.empty() && std::ranges::all_of(done, all_is_well) ? 0 : 1;
}

} // namespace

Command add_run(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "run", "Run models on load cases and compare them with the finite element reference; everything that ships "
               "unless told otherwise");
    auto options = std::make_shared<RunOptions>();
    options->output = (root_folder() / "results" / "runs").string();
    command->add_option("--body", options->bodies, "Names as in 'livermark list bodies', or paths of body .toml files");
    command->add_option("--load-case", options->load_cases,
                        "Names as in 'livermark list load-cases', or paths of load case .toml files");
    command->add_option("--model", options->models,
                        "Names as in 'livermark list models'; the reference and the baseline always run beside them");
    command
        ->add_option("--amplitude", options->amplitudes,
                     "Multiples of the loads, such as 0.1,1,10, to see where linear elasticity stops being a fair "
                     "reference; result files are then <load case>@<amplitude>.h5")
        ->delimiter(',')
        ->check(CLI::PositiveNumber);
    command->add_option("--young", options->young_modulus,
                        "Young's modulus of the first region [Pa]; the others keep their ratio to it");
    command
        ->add_option("--poisson", options->poisson_ratios,
                     "Poisson's ratios of every region, such as 0.25,0.45,0.49; result files are then in a folder "
                     "poisson_<ratio> for each")
        ->delimiter(',');
    command->add_option("--calibration", options->calibration,
                        "A file of 'livermark calibrate' for the body: its springs join as calibrated_nodal_volume");
    command->add_option("--output", options->output, "Folder for <body>/<load case>.h5")->capture_default_str();
    command->add_flag("--no-uncertainty", options->no_uncertainty,
                      "Do not solve the reference on the refined mesh: quicker, but nobody knows how good it is");
    command->add_flag("--static", options->only_static,
                      "Leave load cases that depend on time out: motion takes as long as all the rest");
    using enum fem_reference::SolverChoice;
    command
        ->add_option("--fem-solver", options->model_options.fem_solver,
                     "How the finite elements are solved: auto (by size), direct (sparse Cholesky) or iterative "
                     "(conjugate gradients with algebraic multigrid)")
        ->transform(CLI::CheckedTransformer(
            std::map<std::string, fem_reference::SolverChoice>{
                {"auto", automatic}, {"direct", direct}, {"iterative", iterative}},
            CLI::ignore_case))
        ->default_str("auto");
    command
        ->add_option("--equilibrium", options->model_options.equilibrium,
                     "How mass-spring models find where they come to rest: newton, or relaxation by time stepping")
        ->transform(CLI::CheckedTransformer(
            std::map<std::string, models::EquilibriumMethod>{{"newton", models::EquilibriumMethod::newton},
                                                             {"relaxation", models::EquilibriumMethod::relaxation}},
            CLI::ignore_case))
        ->default_str("newton");
    auto &stepping = options->model_options.time_stepping;
    command
        ->add_option("--integrator", stepping.integrator,
                     "How mass-spring models move in time: a name as in 'livermark list integrators'")
        ->capture_default_str();
    command
        ->add_option("--time-step", stepping.time_step,
                     "Longest step of mass-spring models [s]; by default 0.8 of the longest that is stable")
        ->check([](const std::string &text) {
            double value = 0.0;
            return CLI::detail::lexical_cast(text, value) && value > 0.0 ? "" : "a step in seconds has to be positive";
        });
    command->add_flag("--force-time-step", stepping.force, "Take the step even if it is too long to be stable");
    command->add_flag("--markdown", options->markdown, "Print the table in Markdown");
    return [options, command_line] {
        for (auto *values : {&options->amplitudes, &options->poisson_ratios}) {
            std::ranges::sort(*values);
            values->erase(std::unique(values->begin(), values->end()), values->end());
        }
        return run(*options, command_line);
    };
}

} // namespace livermark::app
