#include <fmt/format.h>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "app/commands.hpp"
#include "app/output.hpp"
#include "app/problems.hpp"
#include "core/whole_file.hpp"
#include "exchange/calculix_input.hpp"
#include "exchange/vtu_output.hpp"
#include "results/provenance.hpp"
#include "results/result_file.hpp"

namespace livermark::app {

namespace {

struct ExportOptions {
    std::string body;
    std::string load_case;
    std::string output = ".";
    bool quadratic = false;
};

void write_text(const std::filesystem::path &file, const std::ostringstream &text) {
    const auto content = text.str();
    core::write_whole(file, content);
    fmt::print("{}\n", file.string());
}

int write_problem(const ExportOptions &options, const std::string &command_line) {
    const auto problem = read_scaled_problems({options.body}, options.load_case, {}).front();
    const auto folder = make_output_folder(options.output, problem);
    const auto file = [&](const char *extension) { return folder / (problem.load_case.name + extension); };

    results::Result result;
    result.provenance = results::current_provenance(command_line);
    result.problem = problem;
    results::write_result(file(".problem.h5"), result);
    fmt::print("{}\n", file(".problem.h5").string());
    std::ostringstream inp, vtu;
    exchange::write_inp(inp, problem, options.quadratic ? 2 : 1);
    write_text(file(".inp"), inp);
    exchange::write_vtu(vtu, problem);
    write_text(file(".vtu"), vtu);
    return 0;
}

} // namespace

Command add_export(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "export", "Write the problem of a load case on a body, for a model outside of this suite to solve: HDF5 (as a "
                  "result file without answers), CalculiX or Abaqus input, and VTU");
    auto options = std::make_shared<ExportOptions>();
    command->add_option("body", options->body, "A name as in 'livermark list bodies', or the path of a body")
        ->required();
    command->add_option("load-case", options->load_case, "A name as in 'livermark list load-cases', or a path")
        ->required();
    command->add_option("-o,--output", options->output, "Folder for <body>/<load case>.inp and the like")
        ->capture_default_str();
    command->add_flag("--quadratic", options->quadratic, "Quadratic tetrahedra (C3D10) in the .inp");
    return [options, command_line] { return write_problem(*options, command_line); };
}

} // namespace livermark::app
