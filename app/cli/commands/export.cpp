#include <fmt/format.h>
#include <memory>
#include <string>

#include "app/cli/commands/commands.hpp"
#include "app/cli/common_options.hpp"
#include "app/cli/image_bodies.hpp"
#include "app/cli/progress.hpp"
#include "studies/arena/arena.hpp"
#include "studies/arena/outside_motion.hpp"
#include "studies/exchange/score.hpp"

namespace livermark::cli {

namespace {

int print_exported(studies::ExportOptions options, const std::string &command_line) {
    options.body = with_image_meshed(options.body, command_line);
    const auto exported = studies::moves_tool(options.load_case) ? studies::export_tool_scene(options, command_line)
                                                                 : studies::export_problem(options, command_line);
    print_notes(exported.notes);
    for (const auto &file : exported.files)
        fmt::print("{}\n", file.string());
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
    command->add_flag("--quadratic", options->quadratic, "Quadratic tetrahedra (C3D10) in the .inp");
    return [options, command_line] { return print_exported(*options, command_line); };
}

} // namespace livermark::cli
