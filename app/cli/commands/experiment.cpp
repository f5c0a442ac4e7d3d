#include <fmt/format.h>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "app/cli/commands.hpp"
#include "core/support/files.hpp"
#include "core/support/processes/child_process.hpp"
#include "load_cases/experiments/experiment.hpp"
#include "results/records/experiment.hpp"
#include "studies/experiments/experiments.hpp"

namespace livermark::cli {

namespace {

struct ExperimentCommand {
    bool list = false, markdown = false, figure = false, reference_on_mesh = false, at_rest = false;
};

void list_experiments(const std::string &data) {
    for (const auto &experiment : experiments::all_public_data()) {
        const auto place = experiments::public_data(experiment.data, data);
        fmt::print("{}: {}\n  published: {}\n  licence: {}\n  here: {}\n  files, with their SHA-256:\n",
                   experiment.name, experiment.title, experiment.source, experiment.licence,
                   place ? place->string() : "no");
        for (const auto &file : experiment.files)
            fmt::print("    {}  {}\n", file.sha256, file.path);
    }
    fmt::print("\nData are looked for in:\n");
    for (const auto &folder : experiments::data_folders(data))
        fmt::print("  {}\n", folder.string());
}

/// A picture beside each file.
void draw_experiments(const std::vector<std::string> &files) {
    for (const auto &file : files)
        fmt::print(stderr, "{}",
                   support::run_python("report.experiment_figure", {file}, {}, "the picture of an experiment",
                                       "python3-h5py and python3-matplotlib"));
}

void print_ring_downs(const results::ExperimentResult &result, bool in_markdown) {
    const auto table = results::ring_down_table(result);
    fmt::print("{}\n\n{}", results::ring_down_note(result), table_text(table, in_markdown));
    for (const auto &ring_down : result.ring_downs)
        for (const auto &run : ring_down.runs)
            if (run.status != core::SolutionStatus::ok)
                fmt::print("{}, {}: {}\n", run.model, results::printable(ring_down.state), run.message);
    fmt::print("\n");
}

int run_command_of_experiments(const ExperimentCommand &command, studies::ExperimentOptions options,
                               const std::string &command_line) {
    refuse_no_folder(options.data);
    if (command.list) {
        list_experiments(options.data);
        return 0;
    }
    options.refines_reference = !command.reference_on_mesh;
    options.rings_down = !command.at_rest;
    const auto found = studies::run_experiments(options, command_line, print_progress());
    print_notes(found.notes);
    for (const auto &result : found.records) {
        fmt::print("{}: {}\n", result.name, result.title);
        for (const auto &assumption : result.assumptions)
            fmt::print("  assumed: {}\n", results::printable(assumption));
        fmt::print("\n");
        if (result.has_compared_markers())
            fmt::print("{}\n{}", table_text(results::experiment_table(result), command.markdown),
                       table_text(results::marker_table(result), command.markdown));
        if (!result.forces.empty())
            fmt::print("{}", table_text(results::force_table(result), command.markdown));
        for (const auto &run : result.runs)
            if (run.status != core::SolutionStatus::ok)
                fmt::print("{}, {}: {}\n", run.model, results::printable(result.states[run.state].name), run.message);
        if (!result.fits.empty())
            fmt::print("{}", table_text(results::fit_table(result), command.markdown));
        for (const auto &note : results::notes_on_nulls(result))
            fmt::print("{}\n", note);
        fmt::print("\n");
        if (!result.ring_downs.empty())
            print_ring_downs(result, command.markdown);
    }
    if (command.figure)
        draw_experiments(found.files);
    fmt::print(stderr, "Result files are in {}\n", options.output);
    return 0;
}

} // namespace

Command add_experiment(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "experiment", "Compare models with measurements of real bodies: print the distance of each model's markers "
                      "from the measured ones, with the noise of the measurement and the uncertainty of the reference");
    auto options = std::make_shared<studies::ExperimentOptions>();
    auto experiment = std::make_shared<ExperimentCommand>();
    command->add_option("experiment", options->names,
                        "Names as in --list, or paths of .toml files of your own "
                        "(docs/howto/bring_your_own_experiment.md); by default all whose data are there");
    command->add_flag(
        "--list", experiment->list,
        "Only list the public experiments: where they are published, their licence, whether their data are "
        "here, and their files");
    add_data(*command, options->data);
    command->add_option("--model", options->models,
                        "Names as in 'livermark list models'; the reference always runs beside them");
    command->add_flag("--methods", options->with_methods,
                      "If no model is named: also the methods of the arena, at the equilibrium to which they converge");
    command
        ->add_option("--edge-length", options->edge_length,
                     "Edge length of the mesh of a box or a cylinder [m], in place of that in the experiment")
        ->check(CLI::Range(1e-5, 1.0));
    command->add_flag(
        "--reference-on-mesh", experiment->reference_on_mesh,
        "Do not solve the reference with each tetrahedron cut into eight: quicker, but its own error stays "
        "unknown");
    command->add_flag("--at-rest", experiment->at_rest, "Leave out ring-downs");
    command->add_flag(
        "--fit", options->fits_materials,
        "Also find Young's modulus, where loads are given, and Poisson's ratio with which each model is nearest "
        "to the markers: some twenty solutions of each");
    command
        ->add_option("--damping", options->damping,
                     "Damping of ring-downs: rayleigh (one ratio at all measured frequencies), or by the mass or the "
                     "stiffness alone")
        ->transform(
            one_of(std::map<std::string, studies::DampingForces>{{"rayleigh", studies::DampingForces::rayleigh},
                                                                 {"mass", studies::DampingForces::mass},
                                                                 {"stiffness", studies::DampingForces::stiffness}}));
    add_output(*command, options->output, "Folder for <experiment>.h5", "experiments");
    command->add_flag("--figure", experiment->figure,
                      "Draw the markers over the deformed body, as <experiment>.png beside the result file");
    command->add_flag("--markdown", experiment->markdown, "Print tables in Markdown");
    return
        [options, experiment, command_line] { return run_command_of_experiments(*experiment, *options, command_line); };
}

} // namespace livermark::cli
