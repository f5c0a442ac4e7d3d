#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "app/commands.hpp"
#include "app/run_tables.hpp"
#include "app/usage.hpp"
#include "core/input_error.hpp"
#include "core/root_folder.hpp"
#include "results/result_file.hpp"

namespace livermark::app {

namespace {

struct TableOptions {
    std::vector<std::string> paths;
    TableKind kind = TableKind::all;
    bool markdown = false;
};

/// The result files below a folder, by name. Other commands leave other files there.
void add_results_below(const std::filesystem::path &path, std::vector<results::Result> &results) {
    std::error_code error;
    std::vector<std::filesystem::path> found;
    for (auto entry = std::filesystem::recursive_directory_iterator(path, error);
         !error && entry != std::filesystem::recursive_directory_iterator(); entry.increment(error))
        if (entry->path().extension() == ".h5")
            found.push_back(entry->path());
    if (error)
        throw core::InputError(
            fmt::format("{}: cannot be listed ({}); see who may read it", path.string(), error.message()));
    std::ranges::sort(found);
    for (const auto &file : found)
        try {
            if (auto result = results::read_result(file); !result.models.empty()) // modes have files of the same kind
                results.push_back(std::move(result));
        } catch (const core::InputError &fault) {
            fmt::print(stderr, "livermark: passed over: {}\n", fault.what());
        }
}

int print(const TableOptions &options) {
    std::vector<results::Result> results;
    for (const auto &path : options.paths)
        if (std::error_code ignored; std::filesystem::is_directory(path, ignored))
            add_results_below(path, results);
        else
            results.push_back(results::read_result(path));
    if (results.empty())
        throw core::InputError(fmt::format("{}: there are no result files here; make some with `livermark run`",
                                           fmt::join(options.paths, ", ")));
    print_tables(results, options.kind, options.markdown);
    return 0;
}

} // namespace

Command add_table(CLI::App &parent) {
    auto *command = parent.add_subcommand("table", "Print the tables of result files that are there");
    auto options = std::make_shared<TableOptions>();
    options->paths = {(core::root_folder() / "results" / "runs").string()};
    command->add_option("paths", options->paths, "Result files of 'livermark run', or folders of them")
        ->capture_default_str();
    command
        ->add_option("--kind", options->kind,
                     "all, models (a row for each model and load case), summary (a column for each load case), "
                     "overview (columns for each Poisson's ratio), or means (a column for each body)")
        ->transform(one_of(table_kinds))
        ->default_str("all");
    command->add_flag("--markdown", options->markdown, "In Markdown");
    return [options] { return print(*options); };
}

} // namespace livermark::app
