#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/commands.hpp"
#include "app/cli/image_bodies.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "results/tables/table.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/models/model_table.hpp"
#include "studies/run/run.hpp"
#include "studies/study.hpp"

namespace livermark::cli {

namespace {

/// Form in which the end of a run is printed.
struct Printing {
    bool tables = false; ///< all of them
    bool markdown = false;
};

int run(const studies::RunOptions &options, Printing printing, const std::string &command_line) {
    studies::TimeSpent spent;
    spent.begin("bodies and load cases");
    const auto prepared = studies::prepare(options);
    if (support::mpi_rank() != 0) {
        studies::run_cases(prepared, command_line, {});
        return 0;
    }
    spent.stop();
    print_notes(prepared.notes);
    const auto outcome = studies::run_cases(prepared, command_line, print_progress());
    const auto &done = outcome.done;
    spent.add(outcome.spent);
    if (!done.empty()) {
        print_tables(done, printing.tables ? TableKind::all : TableKind::brief, printing.markdown);
        if (!options.amplitudes.empty())
            fmt::print("\nDistance of the models from their own linearised solution, at multiples of the load:\n\n{}",
                       table_text(studies::nonlinearity_by_amplitude(done, options.amplitudes), printing.markdown));
    }
    if (printing.tables) {
        results::Layout left_out{{{"left out on"}, {"load case"}, {"because"}}, {}};
        for (const auto &group : studies::grouped(prepared.left_out))
            left_out.rows.push_back({group.body, group.load_case, group.reason});
        if (!left_out.rows.empty())
            fmt::print("\n{}", table_text(left_out, printing.markdown));
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
    const bool all_is_well = std::ranges::all_of(done, [](const results::Result &result) {
        const auto regime = result.problem.load_case.regime;
        return std::ranges::all_of(result.models, [=](const results::ModelResult &model) {
            return model.solution.status == core::SolutionStatus::ok || studies::may_fail(model.name, regime);
        });
    });
    return outcome.failures.empty() && all_is_well ? 0 : 1;
}

struct ReferenceOptions {
    std::vector<std::string> bodies, load_cases, models;
    std::vector<double> poisson_ratios;
    std::string folder;
    bool only_check = false;
};

/// A solution that differs by more from the stored one is another: a thousandth of the discretisation error.
constexpr double largest_difference = 1e-5;

/// Problems that one of the models is stored of, as runs solve them: scaled to their targets.
std::vector<core::Problem> problems_to_keep(const ReferenceOptions &options, const std::vector<core::Model> &models) {
    std::vector<core::Problem> problems;
    const auto read = [&](const meshes::MaterialOverride &material) {
        auto set = studies::read_problems(options.bodies, options.load_cases, material);
        for (auto &problem : set.problems)
            if (std::ranges::any_of(models, [&](const auto &model) { return studies::is_stored(model, problem); }))
                problems.push_back(studies::scaled_to_target(std::move(problem)));
    };
    if (options.poisson_ratios.empty())
        read({});
    for (const double ratio : options.poisson_ratios)
        read({{}, ratio});
    return problems;
}

/// The command that makes the one file again, wherever it is and whatever it was made with.
std::string command_that_stores(const ReferenceOptions &options, const core::Model &model,
                                const core::Problem &problem) {
    auto command = fmt::format("livermark reference --body {} --load-case {} --model {}", problem.body->name,
                               problem.load_case.name, model.name);
    if (!options.poisson_ratios.empty())
        command += fmt::format(" --poisson {:g}", problem.body->materials.front().poisson_ratio);
    return command;
}

int solve_all(const ReferenceOptions &options) {
    auto models = studies::models_to_keep();
    if (!options.models.empty())
        std::erase_if(models, [&](const core::Model &model) {
            return std::ranges::find(options.models, model.name) == options.models.end();
        });
    const auto problems = problems_to_keep(options, models);
    const auto progress = print_progress();
    int num_steps = 0;
    for (const auto &problem : problems)
        for (const auto &model : models)
            num_steps += studies::is_stored(model, problem) ? 1 : 0;
    studies::Steps steps(num_steps, progress);
    const auto as_text = [](double difference) {
        return std::isnan(difference) ? "-" : fmt::format("{:.1e}", difference);
    };
    results::Layout layout{{{"body"},
                            {"load case"},
                            {"model"},
                            {"from stored: L2", true},
                            {"reactions", true},
                            {"motion", true},
                            {"status"}},
                           {}};
    bool all_is_well = true;
    for (const auto &problem : problems)
        for (const auto &model : models) {
            if (!studies::is_stored(model, problem))
                continue;
            steps.next(fmt::format("{} / {} / {}", problem.body->name, problem.load_case.name, model.name));
            const auto stored = studies::solve_and_store(model, problem, options.folder, options.only_check,
                                                         command_that_stores(options, model, problem));
            const bool is_same =
                !(stored.difference > largest_difference) && !(stored.motion_difference > largest_difference);
            const bool is_known = !std::isnan(stored.difference);
            all_is_well = all_is_well && stored.status == core::SolutionStatus::ok && is_same &&
                          (is_known || !options.only_check);
            layout.rows.push_back({problem.body->name, problem.load_case.name, model.name,
                                   is_known ? as_text(stored.difference) : "not stored",
                                   as_text(stored.reaction_difference), as_text(stored.motion_difference),
                                   stored.message.empty() ? core::to_string(stored.status) : stored.message});
        }
    fmt::print("{}", results::to_text(layout));
    return all_is_well ? 0 : 1;
}

} // namespace

Command add_run(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand("run", "Run models on load cases and compare them with the finite element "
                                                 "reference; by default everything that ships");
    auto options = std::make_shared<studies::RunOptions>();
    auto printing = std::make_shared<Printing>();
    auto force = std::make_shared<bool>(false);
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
    add_output(*command, options->output, "Folder for <body>/<load case>.h5");
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
        // Numbers depend neither on how many workers there are nor on whether a run was resumed.
        const auto kept_command_line =
            std::regex_replace(command_line, std::regex(" (--resume|--jobs[ =][0-9]+)(?= |$)"), "");
        options->bodies = with_images_meshed(options->bodies, options->output, kept_command_line, *force);
        return run(*options, *printing, kept_command_line);
    };
}

Command add_reference(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "reference", "Solve and store the references on finer meshes, of large deformations and of motion, which "
                     "'livermark run' and 'livermark score' then read; seconds to minutes for each load case at rest, "
                     "longer in motion");
    auto options = std::make_shared<ReferenceOptions>();
    options->folder = studies::stored_references_folder().string();
    add_bodies(*command, options->bodies);
    command->add_option("--load-case", options->load_cases,
                        "Names as in 'livermark list load-cases', or paths; by default all");
    std::vector<std::string> names;
    for (const auto &model : studies::models_to_keep())
        names.push_back(model.name);
    command->add_option("--model", options->models, "Names of references; by default all")
        ->check(CLI::Validator(
            [names](const std::string &text) {
                return std::ranges::find(names, text) != names.end() ? std::string()
                                                                     : support::unknown_name("reference", text, names);
            },
            "NAME"));
    command
        ->add_option("--poisson", options->poisson_ratios,
                     "Poisson's ratios of every region; by default those of the bodies")
        ->delimiter(',');
    command->add_option("--folder", options->folder, "Folder of the references")->capture_default_str();
    command->add_flag("--check", options->only_check,
                      "Write nothing; exit status 1 if a solution differs from the stored one");
    return [options, command_line] {
        options->bodies = with_images_meshed(options->bodies, command_line);
        return solve_all(*options);
    };
}

} // namespace livermark::cli
