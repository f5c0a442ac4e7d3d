#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include "app/cli/commands/commands.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "studies/report/report_data.hpp"

namespace livermark::cli {

namespace {

struct ReportOptions {
    std::string folder;
    std::string output;
};

std::string page_of(const studies::ReportData &data, const std::string &command_line) {
    return support::run_python("report", {}, studies::report_tables(data, command_line), "a report",
                               "python3-matplotlib python3-jinja2 python3-h5py");
}

/// A file that Python refuses where this program does not, with the sentence: what livermark.report prints in place of
/// a page.
std::optional<std::pair<std::string, std::string>> refused_by_python(const std::string &page) {
    std::istringstream lines(page);
    std::string first, file, sentence;
    if (!std::getline(lines, first) || first != "left out")
        return std::nullopt;
    std::getline(lines, file);
    std::getline(lines, sentence);
    return std::pair(file, sentence);
}

int make_report(const ReportOptions &options, const std::string &command_line) {
    const std::filesystem::path folder = options.folder;
    const std::filesystem::path output =
        options.output.empty() ? folder / "report.html" : std::filesystem::path(options.output);
    auto data = studies::read_report_data(folder);
    support::check_place(output);
    std::map<std::string, std::string> left_out;
    auto page = page_of(data, command_line);
    while (const auto refused = refused_by_python(page)) {
        if (!left_out.insert(*refused).second)
            throw support::InputError(refused->second);
        data = studies::read_report_data(folder, left_out);
        page = page_of(data, command_line);
    }
    support::write_whole(output, page);
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
