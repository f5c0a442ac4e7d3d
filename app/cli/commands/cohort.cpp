#include "studies/cohort/cohort.hpp"

#include <fmt/format.h>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/commands/commands.hpp"
#include "app/cli/common_options.hpp"
#include "app/cli/progress.hpp"
#include "app/cli/run_tables.hpp"

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

} // namespace livermark::cli
