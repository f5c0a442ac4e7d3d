#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/cli/commands/commands.hpp"
#include "app/cli/common_options.hpp"
#include "app/cli/run_tables.hpp"
#include "core/support/files.hpp"
#include "results/hdf5/result_file.hpp"

namespace livermark::cli {

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
    auto *command = parent.add_subcommand("table", "Print tables of existing result files");
    auto options = std::make_shared<TableOptions>();
    options->paths = {(support::root_folder() / "results" / "runs").string()};
    command->add_option("paths", options->paths, "Result files of 'livermark run', or folders of them")
        ->capture_default_str();
    command
        ->add_option(
            "--kind", options->kind,
            "all, brief (two numbers for each model and body, as at the end of a run), models (a row for each model "
            "and load case), forces (of large deformations along the path of the load), summary (a column for each "
            "load case), overview (columns for each Poisson's ratio), means (columns for each body), medians (over "
            "load cases, for each Poisson's ratio, with load cases of pressure separately), or cohort (over bodies "
            "whose names end in a number, odd and even numbers separately)")
        ->transform(one_of(table_kinds))
        ->default_str("all");
    command->add_flag("--markdown", options->markdown, "Print the tables in Markdown");
    return [options] { return print(*options); };
}

} // namespace livermark::cli
