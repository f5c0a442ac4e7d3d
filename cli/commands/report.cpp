#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <string>

#include "cli/commands/commands.hpp"
#include "studies/report/report_data.hpp"
#include "studies/report/report_tables.hpp"
#include "support/processes/python_program.hpp"
#include "support/root_folder.hpp"
#include "support/whole_file.hpp"

namespace livermark::cli {

namespace {

struct ReportOptions {
    std::string folder;
    std::string output;
};

int make_report(const ReportOptions &options, const std::string &command_line) {
    const std::filesystem::path folder = options.folder;
    const std::filesystem::path output =
        options.output.empty() ? folder / "report.html" : std::filesystem::path(options.output);
    const auto data = studies::read_report_data(folder);
    support::check_place(output);
    support::write_whole(output, support::run_python("report", {}, studies::report_tables(data, command_line),
                                                     "a report", "python3-matplotlib python3-jinja2 python3-h5py"));
    fmt::print("{}\n", output.string());
    for (const auto &fault : data.faults)
        fmt::print(stderr, "livermark: left out: {}\n", fault);
    return data.faults.empty() ? 0 : 1;
}

} // namespace

Command add_report(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "report",
        "Write tables, plots and pictures of the result files in a folder into one HTML file, and print its path");
    auto options = std::make_shared<ReportOptions>();
    options->folder = (support::root_folder() / "results" / "runs").string();
    command
        ->add_option("folder", options->folder,
                     "Folder with files of 'livermark run', 'stability' and step_benchmark --hdf5")
        ->capture_default_str();
    command->add_option("-o,--output", options->output, "The HTML file; by default <folder>/report.html");
    return [options, command_line] { return make_report(*options, command_line); };
}

} // namespace livermark::cli
