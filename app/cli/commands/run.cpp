#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <regex>
#include <string>
#include <vector>

#include "app/cli/commands/commands.hpp"
#include "app/cli/common_options.hpp"
#include "app/cli/image_bodies.hpp"
#include "app/cli/progress.hpp"
#include "app/cli/run_tables.hpp"
#include "core/support/files.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "results/tables/table_layout.hpp"
#include "results/tables/tool_cells.hpp"
#include "studies/models/model_table.hpp"
#include "studies/progress.hpp"
#include "studies/run/benchmark_case.hpp"
#include "studies/run/run.hpp"

namespace livermark::cli {

namespace {

bool all_is_well(const results::Result &result) {
    const auto regime = result.problem.load_case.regime;
    return std::ranges::all_of(result.models, [=](const results::ModelResult &model) {
        return model.solution.status == core::SolutionStatus::ok || studies::may_fail(model.name, regime);
    });
}

/// How the end of a run is printed.
struct Printing {
    bool tables = false; ///< all of them
    bool markdown = false;
};

void print_done(const std::vector<results::Result> &done, const std::vector<double> &amplitudes, Printing printing) {
    print_tables(done, printing.tables ? TableKind::all : TableKind::brief, printing.markdown);
    if (!amplitudes.empty()) {
        const auto layout = studies::nonlinearity_by_amplitude(done, amplitudes);
        fmt::print("\nDistance of the models from their own linearised solution, at multiples of the load:\n\n{}",
                   printing.markdown ? results::to_markdown(layout) : results::to_text(layout));
    }
}

int run(const studies::RunOptions &options, Printing printing, const std::string &command_line) {
    studies::TimeSpent spent;
    spent.begin("bodies and load cases");
    const auto prepared = studies::prepare(options);
    if (support::mpi_rank() != 0) {
        studies::help_first_rank(prepared, command_line);
        return 0;
    }
    spent.stop();
    print_notes(prepared.notes);
    const auto outcome = studies::run_cases(prepared, command_line, print_progress());
    const auto &done = outcome.done;
    spent.add(outcome.spent);
    if (!done.empty())
        print_done(done, options.amplitudes, printing);
    if (printing.tables) {
        print_left_out(prepared.left_out, printing.markdown);
        fmt::print(stderr, "\n{}\n", spent.text());
    }
    for (const auto &failure : outcome.failures)
        fmt::print(stderr, "livermark: failed: {}\n", failure);
    print_notes(outcome.notes);
    if (!printing.tables)
        print_notes(studies::sentences(prepared.left_out));
    for (const auto &note : {results::note_on_small_tools(done), results::note_on_small_contacts(done)})
        if (note)
            print_notes({*note});
    fmt::print(stderr, "Result files are in {0}; livermark table {0} prints every load case\n", options.output);
    return outcome.failures.empty() && std::ranges::all_of(done, all_is_well) ? 0 : 1;
}

/// What the result files say: numbers depend neither on how many workers there are nor on whether a run was resumed.
std::string without_jobs_and_resume(const std::string &command_line) {
    return std::regex_replace(command_line, std::regex(" (--resume|--jobs[ =][0-9]+)(?= |$)"), "");
}

} // namespace

Command add_run(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand("run", "Run models on load cases and compare them with the finite element "
                                                 "reference; by default everything that ships");
    auto options = std::make_shared<studies::RunOptions>();
    auto printing = std::make_shared<Printing>();
    auto force = std::make_shared<bool>(false);
    options->output = (support::root_folder() / "results" / "runs").string();
    add_bodies(*command, options->bodies);
    command->add_flag("--force", *force,
                      "Mesh segmentations again, and overwrite their body files in the output folder");
    add_run_choices(*command, options);
    command
        ->add_option("--amplitude", options->amplitudes,
                     "Multiples of the loads, such as 0.1,1,10, to see where linear elasticity stops being a fair "
                     "reference; result files are then <load case>@<amplitude>.h5")
        ->delimiter(',')
        ->check(positive_number());
    command->add_option("--young", options->young_modulus,
                        "Young's modulus of the first region [Pa]; the others keep their ratio to it");
    command->add_option("--calibration", options->calibration,
                        "A file of 'python3 -m livermark.calibration' for the body: its springs run as "
                        "calibrated_nodal_volume, beside those of --model");
    command->add_option("--output", options->output, "Folder for <body>/<load case>.h5")->capture_default_str();
    command->add_flag("--solve-reference", options->solve_reference,
                      "Solve the references even if results/references has their solutions");
    command->add_flag("--static", options->only_static, "Leave out load cases that depend on time: quicker");
    command->add_flag("--resume", options->resume,
                      "Continue the same command, and keep what it has solved in the output folder");
    using enum fem_reference::SolverChoice;
    command
        ->add_option("--fem-solver", options->model_options.fem_solver,
                     "Solver of the finite elements: auto (by size), direct (sparse Cholesky) or iterative (conjugate "
                     "gradients with algebraic multigrid)")
        ->transform(one_of(std::map<std::string, fem_reference::SolverChoice>{
            {"auto", automatic}, {"direct", direct}, {"iterative", iterative}}))
        ->default_str("auto");
    command
        ->add_option("--equilibrium", options->model_options.equilibrium,
                     "Search for the equilibrium of mass-spring models: newton, or relaxation (time stepping, which "
                     "leaves out load cases with a controlled depth)")
        ->transform(one_of(std::map<std::string, models::EquilibriumMethod>{
            {"newton", models::EquilibriumMethod::newton}, {"relaxation", models::EquilibriumMethod::relaxation}}))
        ->default_str("newton");
    auto &stepping = options->model_options.time_stepping;
    command->add_option("--integrator", stepping.integrator,
                        "Integrator of mass-spring models: a name as in 'livermark list integrators'; by default "
                        "runge_kutta_4 or runge_kutta_chebyshev, whichever needs fewer force evaluations, and "
                        "runge_kutta_4 with --equilibrium relaxation");
    command
        ->add_option("--time-step", stepping.time_step,
                     "Longest step of mass-spring models [s]; by default 0.8 of the longest that is stable")
        ->check(positive_number());
    using enum msm::StepKernel;
    command
        ->add_option("--kernel", stepping.kernel,
                     "Kernel for the forces of mass-spring models in motion: simd_float (vector units, single "
                     "precision), simd_double, or scalar (the slow oracle)")
        ->transform(one_of(std::map<std::string, msm::StepKernel>{
            {"simd_float", simd_float}, {"simd_double", simd_double}, {"scalar", scalar}}))
        ->default_str("simd_float");
    command->add_flag("--force-time-step", stepping.force, "Take the step even if it is unstable");
    command->add_flag("--tables", printing->tables,
                      "Print all tables of 'livermark table' and the time of each stage, not only two numbers for each "
                      "model and body");
    command->add_flag("--markdown", printing->markdown, "Print tables in Markdown");
    return [options, printing, force, command_line] {
        options->amplitudes = sorted_once(std::move(options->amplitudes));
        options->poisson_ratios = sorted_once(std::move(options->poisson_ratios));
        const auto kept_command_line = without_jobs_and_resume(command_line);
        options->bodies = with_images_meshed(options->bodies, options->output, kept_command_line, *force);
        return run(*options, *printing, kept_command_line);
    };
}

} // namespace livermark::cli
