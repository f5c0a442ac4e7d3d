#include <fmt/format.h>
#include <memory>

#include "cli/commands/commands.hpp"
#include "cli/common_options.hpp"
#include "cli/image_bodies.hpp"
#include "cli/progress.hpp"
#include "results/tables/studies/history_table.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/histories/histories.hpp"
#include "support/root_folder.hpp"

namespace livermark::cli {

namespace {

int print_histories(studies::HistoriesOptions options, bool markdown, const std::string &command_line) {
    options.bodies = with_images_meshed(options.bodies, command_line);
    const auto found = studies::find_histories(options, command_line, print_progress());
    print_notes(found.notes);
    const auto table = results::history_table(found.of_subject);
    fmt::print("{}", markdown ? results::to_markdown(table) : results::to_text(table));
    fmt::print(stderr, "Result files are in {}\n", options.output);
    return 0;
}

} // namespace

Command add_histories(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand("histories", "Move whole bodies, and the seed paper's model of one degree of "
                                                       "freedom, with the paper's four time steps, stable or not");
    auto options = std::make_shared<studies::HistoriesOptions>();
    auto markdown = std::make_shared<bool>(false);
    options->output = (support::root_folder() / "results" / "runs").string();
    add_bodies(*command, options->bodies);
    command->add_option("--law", options->law, "A name as in 'livermark list spring-laws'")->capture_default_str();
    command
        ->add_option("--load-case", options->load_case,
                     "A load case with a [release], which has the released load and the damping")
        ->capture_default_str();
    command->add_option("--integrator", options->integrator, "A name as in 'livermark list integrators'")
        ->capture_default_str();
    command->add_option("--time-step", options->time_steps, "Time steps [s]")
        ->check(CLI::Range(1e-6, 1e6))
        ->capture_default_str();
    command->add_option("--duration", options->duration, "Duration [s]")
        ->check(CLI::Range(1e-3, 1e6))
        ->capture_default_str();
    add_materials(*command, options->material);
    command->add_option("--output", options->output, "Folder for <body>/histories.<law>.h5")->capture_default_str();
    command->add_flag("--markdown", *markdown, "Print the table in Markdown");
    return [=] { return print_histories(*options, *markdown, command_line); };
}

} // namespace livermark::cli
