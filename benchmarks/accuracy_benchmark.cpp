// Error against cost of every model, integrator and time step in result files of `livermark run`; see README.md.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <vector>

#include "results/hdf5/result_files.hpp"
#include "results/tables/accuracy.hpp"
#include "support/input_error.hpp"
#include "support/root_folder.hpp"

namespace {

namespace results = livermark::results;

void print(const results::Layout &layout, bool markdown) {
    fmt::print("{}\n", markdown ? results::to_markdown(layout) : results::to_text(layout));
}

int run(int argc, char **argv) {
    CLI::App app("Error against cost of what is in result files, with the Pareto front");
    std::vector<std::filesystem::path> paths{livermark::support::root_folder() / "results" / "runs"};
    app.add_option("paths", paths, "Result files of 'livermark run', or folders of them")->capture_default_str();
    bool markdown = false;
    app.add_flag("--markdown", markdown, "In Markdown");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    const auto found = results::read_results(paths);
    print(results::static_accuracy(found), markdown);
    print(results::motion_accuracy(found), markdown);
    return 0;
}

} // namespace

int main(int argc, char **argv) {
    try {
        return run(argc, argv);
    } catch (const livermark::support::InputError &error) {
        std::fprintf(stderr, "accuracy_benchmark: %s\n", error.what());
        return 2;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "accuracy_benchmark: %s\n", error.what());
        return 1;
    }
}
