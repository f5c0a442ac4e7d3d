#include <fmt/format.h>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "app/cli/commands.hpp"
#include "app/cli/image_bodies.hpp"
#include "core/support/files.hpp"
#include "results/records/arena.hpp"
#include "studies/arena/arena.hpp"
#include "studies/exchange/exchange.hpp"

namespace livermark::cli {

namespace {

int print_exported(studies::ExportOptions options, const std::string &command_line) {
    options.body = with_image_meshed(options.body, command_line);
    const auto exported = studies::export_problem(options, command_line);
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

} // namespace

Command add_export(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "export", "Write the problem of a load case on a body, for another program to solve: HDF5 (a result file "
                  "without solutions), CalculiX or Abaqus input, and VTU; with a moving tool HDF5 with the path of the "
                  "tool, a job for FEBio and a scene for SOFA");
    auto options = std::make_shared<studies::ExportOptions>();
    add_body(*command, options->body);
    command
        ->add_option("load-case,--load-case", options->load_case, "A name as in 'livermark list load-cases', or a path")
        ->required();
    command->add_option("-o,--output", options->output, "Folder for <body>/<load case>.inp and the other files")
        ->capture_default_str();
    std::vector<std::string> formats;
    for (const auto &format : exchange::all_formats())
        formats.push_back(fmt::format("{} ({})", format.name, format.summary));
    command->add_option("--format", options->formats,
                        fmt::format("Formats beside HDF5: {}; by default calculix and vtu", fmt::join(formats, ", ")));
    command->add_flag("--quadratic", options->choices.quadratic, "Quadratic tetrahedra (C3D10) in the .inp");
    return [options, command_line] { return print_exported(*options, command_line); };
}

Command add_score(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "score", "Compare another program's displacements for a problem of 'livermark export' with the reference");
    auto options = std::make_shared<studies::ScoreOptions>();
    auto markdown = std::make_shared<bool>(false);
    add_body(*command, options->body);
    command->add_option("load-case,--load-case", options->load_case, "As for 'livermark export'")->required();
    command
        ->add_option(
            "solution,--solution", options->solution,
            "Node displacements [m]: CSV with the header x,y,z,ux,uy,uz, HDF5 with the datasets points and "
            "displacement, or VTU with the point data displacement; in any order. Under a moving tool: HDF5 with "
            "displacement and force over time")
        ->required();
    command->add_option("--unit", options->unit,
                        "Unit of the displacements: m, cm or mm, or its length in metres, such as 0.025; coordinates "
                        "may have it too. By default metres, and implausible sizes are refused");
    command->add_option("--name", options->name, "Name of the model in table and result file")
        ->check(CLI::Validator(studies::fault_of_name, "NAME"))
        ->capture_default_str();
    command->add_option("--model", options->models, "Models to compare it with, as in 'livermark list models'")
        ->capture_default_str();
    add_output(*command, options->output, "Folder for <body>/<load case>.<name>.h5", "scores");
    add_reference_on_mesh(*command, options->reference_on_mesh);
    command->add_flag("--solve-reference", options->solve_reference,
                      "Solve the reference even if results/references has its solution");
    command->add_flag("--markdown", *markdown, "Print the table in Markdown");
    return [=] { return print_score(*options, *markdown, command_line); };
}

} // namespace livermark::cli
