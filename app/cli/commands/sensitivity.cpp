#include <fmt/format.h>
#include <memory>
#include <string>

#include "app/cli/commands/commands.hpp"
#include "app/cli/common_options.hpp"
#include "app/cli/image_bodies.hpp"
#include "app/cli/progress.hpp"
#include "core/support/files.hpp"
#include "studies/sensitivity/sensitivity.hpp"

namespace livermark::cli {

namespace {

struct SensitivityFormat {
    bool json = false, markdown = false;
};

int run_sensitivity(studies::SensitivityOptions options, const SensitivityFormat &format,
                    const std::string &command_line) {
    const auto bodies = with_images_meshed({options.body}, options.output, command_line, false);
    options.body = bodies.front();
    const auto done = studies::study_sensitivity(options, command_line, print_progress());
    print_notes(done.notes);
    fmt::print("{}", studies::shown_sensitivities(done.files, format.json       ? "json"
                                                              : format.markdown ? "markdown"
                                                                                : "text"));
    fmt::print(stderr, "Result files are in {}\n", done.folder);
    return 0;
}

} // namespace

Command add_sensitivity(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "sensitivity", "Compute how uncertain the stiffness at the tool and displacements are while stiffness, support "
                       "and place of the tool of a patient are unknown, beside the errors of mesh, model and law");
    auto options = std::make_shared<studies::SensitivityOptions>();
    auto format = std::make_shared<SensitivityFormat>();
    options->output = (support::root_folder() / "results" / "runs").string();
    add_body(*command, options->body);
    command->add_option("--load-case", options->load_cases, "Names or paths of small load cases at rest")
        ->capture_default_str();
    command
        ->add_option("--samples", options->num_samples,
                     "Number of patients; a larger sample begins with the smaller one")
        ->check(CLI::Range(4, 65536))
        ->capture_default_str();
    command->add_option("--model", options->model, "The model that solves them; another model starts the file again")
        ->capture_default_str();
    command
        ->add_option("--compare", options->compared,
                     "Models whose errors are in the budget; the sentence at the end is about the first")
        ->capture_default_str();
    command->add_option("--ranges", options->ranges,
                        "Ranges of the parameters with their sources (TOML); by default results/parameter_ranges.toml");
    command->add_flag("--without-law", options->without_law,
                      "Do not solve the large load case with two laws, which takes minutes");
    add_reference_on_mesh(*command, options->reference_on_mesh);
    command
        ->add_option("--output", options->output,
                     "Folder for <body>/sensitivity.<load case>.h5; existing samples are continued")
        ->capture_default_str();
    command->add_flag("--json", format->json, "Print JSON, in SI units");
    command->add_flag("--markdown", format->markdown, "Print tables in Markdown");
    return [=] { return run_sensitivity(*options, *format, command_line); };
}

} // namespace livermark::cli
