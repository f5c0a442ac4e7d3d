#include <fmt/format.h>
#include <memory>

#include "app/cli/commands/commands.hpp"
#include "app/cli/common_options.hpp"
#include "app/cli/image_bodies.hpp"
#include "app/cli/progress.hpp"
#include "core/support/files.hpp"
#include "results/tables/table.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/models/model_table.hpp"
#include "studies/modes/modes.hpp"

namespace livermark::cli {

namespace {

int print_modes(studies::ModesOptions options, bool markdown, const std::string &command_line) {
    options.bodies = with_images_meshed(options.bodies, command_line);
    const auto found = studies::find_modes(options, command_line, print_progress());
    print_notes(found.notes);
    for (const auto &result : found.of_body) {
        const auto table = results::modes_table(result, models::moving_reference(core::Regime::small).on_mesh);
        fmt::print("{}, constrained as in {}\n{}\n", result.problem.body->name, result.problem.load_case.name,
                   markdown ? results::to_markdown(table) : results::to_text(table));
    }
    fmt::print(stderr, "Result files are in {}\n", options.output);
    return 0;
}

} // namespace

Command add_modes(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand("modes", "Find the lowest frequencies and modes of constrained bodies");
    auto options = std::make_shared<studies::ModesOptions>();
    auto markdown = std::make_shared<bool>(false);
    options->output = (support::root_folder() / "results" / "runs").string();
    add_bodies(*command, options->bodies);
    add_constraints(*command, options->load_case);
    command->add_option("--model", options->models, "Models that can compute their modes")->capture_default_str();
    command->add_option("--count", options->count, "Number of modes")
        ->check(CLI::Range(1, studies::most_modes))
        ->capture_default_str();
    add_materials(*command, options->material);
    command->add_option("--output", options->output, "Folder for <body>/modes.<load case>.h5")->capture_default_str();
    command->add_flag("--markdown", *markdown, "Print the tables in Markdown");
    return [=] { return print_modes(*options, *markdown, command_line); };
}

} // namespace livermark::cli
