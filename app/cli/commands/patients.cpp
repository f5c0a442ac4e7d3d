#include "studies/cohort/cohort.hpp"

#include <fmt/format.h>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/commands.hpp"
#include "app/cli/image_bodies.hpp"
#include "core/support/files.hpp"
#include "studies/sensitivity/sensitivity.hpp"

namespace livermark::cli {

namespace {

struct CohortCommand {
    std::string bodies;
    int tetrahedra = 0;
    bool markdown = false;
};

void print_kept(const studies::CohortOutcome &outcome) {
    std::vector<std::string> whole, parts;
    for (const auto &[body, num_kept, num_load_cases] : outcome.kept)
        if (num_kept == num_load_cases)
            whole.push_back(body);
        else
            parts.push_back(fmt::format("{} of {} load cases of {}", num_kept, num_load_cases, body));
    if (!whole.empty())
        print_notes({fmt::format("kept: {}", fmt::join(whole, ", "))});
    if (!parts.empty())
        print_notes({fmt::format("kept: {}", fmt::join(parts, ", "))});
}

int run_command_of_cohort(const CohortCommand &command, const studies::RunOptions &run,
                          const std::string &command_line) {
    const studies::CohortOptions options{
        .bodies = studies::body_numbers(command.bodies), .tetrahedra = command.tetrahedra, .run = run};
    auto outcome = studies::run_cohort(options, command_line, print_progress());
    if (!outcome.cohort.errors.empty())
        print_cohort(outcome.cohort.errors, command.markdown);
    fmt::print(stderr, "\n{}\n", outcome.spent.text());
    print_notes(outcome.notes);
    print_kept(outcome);
    for (const auto &failure : outcome.cohort.failures)
        fmt::print(stderr, "livermark: failed: {}\n", failure);
    fmt::print(stderr, "Result files are in {}, and what they come to is in cohort.h5 there\n", run.output);
    return outcome.is_well ? 0 : 1;
}

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

Command add_cohort(CLI::App &parent, const std::string &command_line) {
    auto *command =
        parent.add_subcommand("cohort", "Make livers of other people, run models on their static load cases, and print "
                                        "statistics of the errors over bodies. Existing bodies and results are kept");
    auto options = std::make_shared<CohortCommand>();
    auto run = std::make_shared<studies::RunOptions>();
    command
        ->add_option("--bodies", options->bodies,
                     "Numbers of the livers, as for `livermark mesh liver --variant`: numbers and ranges, such as "
                     "1-8,12. Odd numbers are the tuning half, even numbers the test half")
        ->required();
    command
        ->add_option("--tetrahedra", options->tetrahedra,
                     "Approximate number of tetrahedra of each body; by default that of the livers that ship")
        ->check(CLI::Range(2000, 2000000));
    add_run_choices(*command, run);
    command
        ->add_option("--output", run->output,
                     "Folder for bodies/<body>.toml, <body>/<load case>.h5 and cohort.h5 (the errors of all bodies)")
        ->required();
    command->add_flag("--markdown", options->markdown, "Print the table in Markdown");
    return [options, run, command_line] {
        run->poisson_ratios = sorted_once(std::move(run->poisson_ratios));
        return run_command_of_cohort(*options, *run, command_line);
    };
}

Command add_sensitivity(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "sensitivity", "Compute how uncertain the stiffness at the tool and displacements are while stiffness, support "
                       "and place of the tool of a patient are unknown, beside the errors of mesh, model and law");
    auto options = std::make_shared<studies::SensitivityOptions>();
    auto format = std::make_shared<SensitivityFormat>();
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
                        "Ranges of the parameters with their sources (TOML); by default results/parameter_ranges.toml. "
                        "Those with _indentation, _relaxing, _capsule and _map in their names are beside it");
    command->add_flag("--without-law", options->without_law,
                      "Do not solve the large load case with two laws, which takes minutes");
    add_reference_on_mesh(*command, options->reference_on_mesh);
    add_output(*command, options->output,
               "Folder for <body>/sensitivity.<load case>.h5; existing samples are continued");
    command->add_flag("--json", format->json, "Print JSON, in SI units");
    command->add_flag("--markdown", format->markdown, "Print tables in Markdown");
    return [=] { return run_sensitivity(*options, *format, command_line); };
}

} // namespace livermark::cli
