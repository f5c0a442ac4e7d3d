#include <fmt/format.h>
#include <memory>

#include "app/cli/commands/commands.hpp"
#include "app/cli/common_options.hpp"
#include "app/cli/image_bodies.hpp"
#include "app/cli/progress.hpp"
#include "core/support/files.hpp"
#include "results/records/cut.hpp"
#include "studies/cutting/cut_study.hpp"

namespace livermark::cli {

namespace {

int print_cut(studies::CutStudyOptions options, bool markdown, const std::string &command_line) {
    options.body = with_image_meshed(options.body, command_line);
    const auto done = studies::let_blade_in(options, command_line, print_progress());
    print_notes(done.notes);
    const auto &file = done.file;
    fmt::print("{}: {}\n{} step by step:\n\n", file.body, results::printable(file.title), file.runs.front().model);
    for (const auto &table : {results::cut_table(file), results::cut_models_table(file)})
        fmt::print("{}\n", markdown ? results::to_markdown(table) : results::to_text(table));
    fmt::print("{}\n", results::cut_judge_note(file));
    if (!file.levels.empty()) {
        const auto table = results::cut_levels_table(file);
        fmt::print("{} in the end, on meshes that are finer and finer at the rim of the wound:\n\n{}\n{}\n",
                   file.runs.front().model, markdown ? results::to_markdown(table) : results::to_text(table),
                   results::cut_levels_note(file));
    }
    if (const auto table = results::cut_steps_table(file); !table.rows.empty())
        fmt::print(
            "Longest stable step of springs, by symplectic Euler with nothing damped and nothing constrained:\n\n"
            "{}\n",
            markdown ? results::to_markdown(table) : results::to_text(table));
    if (!file.motions.empty()) {
        const auto table = results::cut_motions_table(file);
        fmt::print("Methods that move in frames of {:.1f} ms, {} for each step of the blade:\n\n{}\n",
                   1e3 * file.frame_interval, file.frames_per_step,
                   markdown ? results::to_markdown(table) : results::to_text(table));
    }
    fmt::print("{}", results::cut_note(file));
    fmt::print(stderr, "The result file is in {}\n", options.output);
    return 0;
}

} // namespace

Command add_cut(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "cut", "Move a blade into a body under load, step by step, and print the opening of the wound, the released "
               "energy and the time of each step for each model, beside the reference");
    auto options = std::make_shared<studies::CutStudyOptions>();
    auto markdown = std::make_shared<bool>(false);
    auto budgets = std::make_shared<std::vector<double>>(std::vector{1.0, 4.0, 1000.0 / 60.0});
    options->output = (support::root_folder() / "results" / "runs").string();
    add_body(*command, options->body);
    command
        ->add_option("--load-case", options->load_case,
                     "The load while the blade goes in: a name as in 'livermark list load-cases', or a path")
        ->capture_default_str();
    command
        ->add_option("--blade", options->blade,
                     "The quadrilateral that the edge of the blade sweeps, as twelve numbers [m]: four corners in "
                     "turn; the edge goes from the side 0-1 to the side 3-2")
        ->expected(12)
        ->required();
    command->add_option("--steps", options->num_steps, "Number of steps of the blade")->capture_default_str();
    command->add_option("--toughness", options->toughness, "Toughness of the tissue, energy over area [J/m^2]")
        ->capture_default_str();
    command
        ->add_option(
            "--regime", options->regime,
            "Which models are compared: small (reference: linear elasticity) or large (reference: hyperelasticity on "
            "each cut body; minutes); by default that of the load case")
        ->transform(a_regime());
    command
        ->add_option("--refine", options->num_refined,
                     "How often the reference is refined at the rim of the wound in the end, for its error bar; 0 for "
                     "none")
        ->capture_default_str();
    command->add_option(
        "--model", options->models,
        "Names as in 'livermark list models', beside the reference on the mesh; by default those of a run");
    command->add_option("--method", options->motion.methods,
                        "Names as in 'livermark list methods', or all, of methods that move while the blade goes in, "
                        "under a load case of the small regime; none by default");
    command->add_option("--budget", *budgets, "With --method: processor times of one core for a frame [ms]")
        ->check(CLI::Range(0.01, 1e5))
        ->capture_default_str();
    command->add_option("--frames", options->motion.frames_per_step, "With --method: frames for each step of the blade")
        ->capture_default_str();
    add_materials(*command, options->material);
    command
        ->add_option("--output", options->output,
                     "Folder for <body>/cut.<load case>.h5, or cut.<load case>.large.h5 with --regime large")
        ->capture_default_str();
    command->add_flag("--markdown", *markdown, "Print the tables in Markdown");
    return [=] {
        options->motion.budgets.clear();
        for (const double budget : *budgets)
            options->motion.budgets.push_back(1e-3 * budget);
        return print_cut(*options, *markdown, command_line);
    };
}

} // namespace livermark::cli
