#include "app/run_options.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>

#include "app/amplitudes.hpp"
#include "app/hold_all.hpp"
#include "app/run_tables.hpp"
#include "app/run_task.hpp"
#include "app/time_spent.hpp"
#include "fem_reference/mpi_session.hpp"
#include "results/table_layout.hpp"

namespace livermark::app {

namespace {

bool all_is_well(const results::Result &result) {
    return std::ranges::all_of(result.models, [](const results::ModelResult &model) {
        return model.solution.status == core::SolutionStatus::ok && results::meets_band(model).value_or(true);
    });
}

void print_all(const std::vector<results::Result> &done, const RunOptions &options) {
    print_tables(done, TableKind::all, options.markdown);
    if (!options.amplitudes.empty()) {
        const auto layout = nonlinearity_by_amplitude(done, options.amplitudes);
        fmt::print("\nDistance of models from their own linearised answer, at multiples of the load:\n\n{}",
                   options.markdown ? results::to_markdown(layout) : results::to_text(layout));
    }
}

} // namespace

int run(const RunOptions &options, const std::string &command_line) {
    TimeSpent spent;
    spent.begin("bodies and load cases");
    const auto task = prepare(options);
    if (fem_reference::mpi_rank() != 0) {
        help_first_rank(task, options, command_line);
        return 0;
    }

    spent.stop();
    auto outcomes = hold_all(task, options, command_line);
    for (const auto &[stage, seconds] : outcomes.spent.stages())
        spent.add(stage, seconds);
    std::vector<results::Result> done;
    std::vector<std::string> failures;
    for (auto &outcome : outcomes.of_problem) {
        std::ranges::move(outcome.done, std::back_inserter(done));
        std::ranges::move(outcome.failures, std::back_inserter(failures));
    }
    print_all(done, options);
    fmt::print(stderr, "\n{}\n", spent.text());
    for (const auto &failure : failures)
        fmt::print(stderr, "livermark: failed: {}\n", failure);
    fmt::print(stderr, "Result files are in {}\n", options.output);
    return failures.empty() && std::ranges::all_of(done, all_is_well) ? 0 : 1;
}

} // namespace livermark::app
