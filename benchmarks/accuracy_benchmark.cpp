// Error against cost of every model, integrator and time step in result files of `livermark run`; see README.md.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <fmt/format.h>
#include <vector>

#include "core/input_error.hpp"
#include "core/root_folder.hpp"
#include "results/accuracy.hpp"
#include "results/result_files.hpp"

int main(int argc, char **argv) {
    namespace results = livermark::results;
    CLI::App app("Error against cost of what is in result files, with the Pareto front");
    std::vector<std::filesystem::path> paths{livermark::core::root_folder() / "results" / "runs"};
    app.add_option("paths", paths, "Result files of 'livermark run', or folders of them")->capture_default_str();
    bool markdown = false;
    app.add_flag("--markdown", markdown, "In Markdown");
    CLI11_PARSE(app, argc, argv);
    try {
        const auto found = results::read_results(paths);
        const auto print = [&](const results::Layout &layout) {
            fmt::print("{}", markdown ? results::to_markdown(layout) : results::to_text(layout));
        };
        print(results::static_accuracy(found));
        fmt::print("\n");
        print(results::motion_accuracy(found));
    } catch (const livermark::core::InputError &error) {
        fmt::print(stderr, "accuracy_benchmark: {}\n", error.what());
        return 2;
    } catch (const std::exception &error) {
        fmt::print(stderr, "accuracy_benchmark: {}\n", error.what());
        return 1;
    }
    return 0;
}
