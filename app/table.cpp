#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/commands.hpp"
#include "app/run_tables.hpp"
#include "app/usage.hpp"
#include "core/root_folder.hpp"
#include "results/result_files.hpp"

namespace livermark::app {

namespace {

struct TableOptions {
    std::vector<std::string> paths;
    TableKind kind = TableKind::all;
    bool markdown = false;
};

int print(const TableOptions &options) {
    const std::vector<std::filesystem::path> paths(options.paths.begin(), options.paths.end());
    const auto results = results::read_results(paths);
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
