#include <fmt/format.h>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/commands.hpp"
#include "app/cli/image_bodies.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "results/records/arena.hpp"
#include "results/records/engine_entry.hpp"
#include "studies/arena/arena.hpp"
#include "studies/exchange/engine_board.hpp"
#include "studies/exchange/exchange.hpp"

namespace livermark::cli {

namespace {

/// @param names  of options, each with what it was given
void require(const std::string &command, std::initializer_list<std::pair<const char *, std::string>> names) {
    for (const auto &[name, given] : names)
        if (given.empty())
            throw support::InputError("{} is required; see `livermark {} --help`", name, command);
}

/// Refuses options beside one that stands for them.
void refuse_beside(const char *option, std::initializer_list<const CLI::Option *> others) {
    for (const auto *other : others)
        if (other->count() > 0)
            throw support::InputError("{} goes without {}; leave one of them out", option, other->get_name());
}

int print_exported(const studies::ExportedProblem &exported) {
    print_notes(exported.notes);
    for (const auto &file : exported.files)
        fmt::print("{}\n", file.string());
    return 0;
}

int print_motion_score(const studies::ScoreOptions &options, bool markdown, const std::string &command_line) {
    const auto scored = studies::score_motion(options, command_line, print_progress());
    print_notes(scored.notes);
    const auto table = results::arena_table(scored.arena);
    fmt::print("{}: {}, against {}\n\n", scored.arena.body, scored.arena.title, scored.arena.reference);
    fmt::print("{}\n{}", table_text(table, markdown), results::arena_legend());
    fmt::print(stderr, "The result file is {}\n", scored.file.string());
    return 0;
}

int print_score(studies::ScoreOptions options, bool markdown, const std::string &command_line) {
    options.body = with_image_meshed(options.body, command_line);
    if (studies::moves_tool(options.load_case))
        return print_motion_score(options, markdown, command_line);
    const auto scored = studies::score(options, command_line, print_progress());
    print_notes(scored.notes);
    print_tables(std::span(&scored.result, 1), TableKind::models, markdown);
    fmt::print(stderr, "The result file is {}\n", scored.file.string());
    return 0;
}

int print_engine_entry(const studies::EntryOptions &options, bool markdown, const std::string &command_line) {
    const auto scored = studies::score_entry(options, command_line, print_progress());
    print_notes(scored.notes);
    fmt::print("{} {}\n\n{}\n{}", scored.entry.engine, scored.entry.version,
               table_text(results::engine_entry_table(scored.entry), markdown), results::engine_entry_legend());
    int status = 0;
    for (const auto &problem : scored.entry.problems) {
        if (!problem.message.empty())
            fmt::print(stderr, "livermark: {} / {}: {}\n", problem.body, problem.load_case,
                       results::printable(problem.message));
        status = problem.has_failed() ? 1 : status;
    }
    fmt::print(stderr, "The entry is {}\n", scored.file.string());
    return status;
}

} // namespace

Command add_export(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "export", "Write the problem of a load case on a body, for another program to solve: HDF5 (a result file "
                  "without solutions), CalculiX or Abaqus input, and VTU; with a moving tool HDF5 with the path of the "
                  "tool, a job for FEBio and a scene for SOFA. With --board instead of a body and a load case: all "
                  "problems of two livers that nobody tuned on");
    auto options = std::make_shared<studies::ExportOptions>();
    auto board = std::make_shared<int>(0);
    auto *body = add_body(*command, options->body)->required(false);
    auto *load_case = command->add_option("load-case,--load-case", options->load_case,
                                          "A name as in 'livermark list load-cases', or a path");
    command
        ->add_option("--board", *board,
                     "Seed that two livers are drawn by; writes their problems, the bodies, and an entry.toml for "
                     "`livermark score --entry`")
        ->check(CLI::Range(1, 1000000));
    command->add_option("-o,--output", options->output, "Folder for <body>/<load case>.inp and the other files")
        ->capture_default_str();
    std::vector<std::string> formats;
    for (const auto &format : exchange::all_formats())
        formats.push_back(fmt::format("{} ({})", format.name, format.summary));
    command->add_option("--format", options->formats,
                        fmt::format("Formats beside HDF5: {}; by default calculix and vtu", fmt::join(formats, ", ")));
    command->add_flag("--quadratic", options->choices.quadratic, "Quadratic tetrahedra (C3D10) in the .inp");
    return [=] {
        if (*board > 0) {
            refuse_beside("--board", {body, load_case});
            return print_exported(studies::export_board(*board, *options, command_line, print_progress()));
        }
        require("export", {{"--body", options->body}, {"--load-case", options->load_case}});
        auto chosen = *options;
        chosen.body = with_image_meshed(chosen.body, command_line);
        return print_exported(studies::export_problem(chosen, command_line));
    };
}

Command add_score(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "score", "Compare another program's displacements for a problem of 'livermark export' with the reference. With "
                 "--entry instead of a body, a load case and a solution: all problems of an engine");
    auto options = std::make_shared<studies::ScoreOptions>();
    auto entry = std::make_shared<std::string>();
    auto markdown = std::make_shared<bool>(false);
    auto *body = add_body(*command, options->body)->required(false);
    auto *load_case = command->add_option("load-case,--load-case", options->load_case, "As for 'livermark export'");
    auto *solution = command->add_option(
        "solution,--solution", options->solution,
        "Node displacements [m]: CSV with the header x,y,z,ux,uy,uz, HDF5 with the datasets points and displacement, "
        "or VTU with the point data displacement; in any order. Under a moving tool: HDF5 with displacement and force "
        "over time");
    command->add_option("--entry", *entry,
                        "A .toml that names an engine and its solutions, such as the entry.toml of `livermark export "
                        "--board`; writes <engine>.json beside it, or in the folder of --output");
    auto *unit = command->add_option(
        "--unit", options->unit,
        "Unit of the displacements: m, cm or mm, or its length in metres, such as 0.025; coordinates "
        "may have it too. By default metres, and implausible sizes are refused");
    auto *name = command->add_option("--name", options->name, "Name of the model in table and result file")
                     ->check(CLI::Validator(studies::fault_of_name, "NAME"))
                     ->capture_default_str();
    command->add_option("--model", options->models, "Models to compare it with, as in 'livermark list models'")
        ->capture_default_str();
    auto *output = add_output(*command, options->output, "Folder for <body>/<load case>.<name>.h5", "scores");
    add_reference_on_mesh(*command, options->reference_on_mesh);
    command->add_flag("--solve-reference", options->solve_reference,
                      "Solve the reference even if results/references has its solution");
    command->add_flag("--markdown", *markdown, "Print the table in Markdown");
    return [=] {
        if (entry->empty()) {
            require(
                "score",
                {{"--body", options->body}, {"--load-case", options->load_case}, {"--solution", options->solution}});
            return print_score(*options, *markdown, command_line);
        }
        refuse_beside("--entry", {body, load_case, solution, unit, name});
        return print_engine_entry({.entry = *entry,
                                   .output = output->count() > 0 ? options->output : "",
                                   .models = options->models,
                                   .reference_on_mesh = options->reference_on_mesh,
                                   .solve_reference = options->solve_reference},
                                  *markdown, command_line);
    };
}

} // namespace livermark::cli
