#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <memory>

#include "app/cli/commands.hpp"
#include "app/cli/image_bodies.hpp"
#include "core/support/files.hpp"
#include "core/units.hpp"
#include "msm/dynamics/time_step.hpp"
#include "results/records/springs.hpp"
#include "results/tables/table.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/frequencies/frequencies.hpp"
#include "studies/models/model_table.hpp"

namespace livermark::cli {

namespace {

int print_modes(studies::ModesOptions options, bool markdown, const std::string &command_line) {
    options.bodies = with_images_meshed(options.bodies, command_line);
    const auto found = studies::find_modes(options, command_line, print_progress());
    print_notes(found.notes);
    for (const auto &result : found.records) {
        const auto table = results::modes_table(result, models::moving_reference(core::Regime::small).on_mesh);
        fmt::print("{}, constrained as in {}\n{}\n", result.problem.body->name, result.problem.load_case.name,
                   table_text(table, markdown));
    }
    fmt::print(stderr, "Result files are in {}\n", options.output);
    return 0;
}

using core::microseconds;
using core::milliseconds;
using core::percent;

void print(const results::Stability &stability, bool markdown) {
    const char *end = markdown ? "\n\n" : "\n";
    fmt::print("{}, springs of {}, constrained as in {}{}", stability.body, stability.springs(), stability.load_case,
               end);
    fmt::print("angular frequencies {:.2f} to {:.2f} rad/s (Gershgorin's bound: {:.2f} rad/s){}",
               stability.lowest_frequency, stability.largest_frequency, stability.largest_frequency_bound, end);
    fmt::print("mean edge over speed of sound, of the first region: {:.3f} ms{}",
               milliseconds * stability.element_time_step, end);
    fmt::print("damping: alpha = {:.4f} 1/s, beta = {:.4e} s, which is {:.3f} of critical at the largest frequency{}\n",
               stability.damping.alpha, stability.damping.beta, stability.damping.ratio(stability.largest_frequency),
               markdown ? "\n" : "");
    const auto layout = results::stability_table(stability);
    fmt::print("{}\n", table_text(layout, markdown));
}

/// Meanings of the words in the tables.
void print_legend(const std::vector<results::Stability> &all, bool looked) {
    const auto any_limit = [&](auto &&is_so) {
        return std::ranges::any_of(all, [&](const auto &stability) {
            return std::ranges::any_of(
                stability.limits, [&](const auto &limits) { return is_so(limits.undamped) || is_so(limits.damped); });
        });
    };
    if (any_limit([](const auto &limit) { return limit.predicted == 0.0; }))
        fmt::print("none: no stable step; oscillations grow at every step, more slowly at smaller steps\n");
    if (any_limit([](const auto &limit) { return !limit.has_number() && limit.predicted > 0.0; }))
        fmt::print("any: stable at every step\n");
    if (looked && any_limit([](const auto &limit) { return limit.has_number() && std::isnan(limit.observed); }))
        fmt::print("not observed: just above the limit a motion grows too slowly to be seen in a run\n");
}

results::Layout scaled_steps_table(const std::vector<studies::ScaledSteps> &all) {
    results::Layout layout{.columns = {{"model"},
                                       {"body"},
                                       {"critical step [ms]", true},
                                       {"of the soft tissue [ms]", true},
                                       {"scaled [ms]", true},
                                       {"scaled nodes", true},
                                       {"heavier by", true},
                                       {"first frequency [%]", true},
                                       {fmt::format("worst of {} [%]", studies::num_compared_modes), true},
                                       {"step [us]", true},
                                       {"scaled [us]", true},
                                       {"simulated second [s]", true},
                                       {"scaled [s]", true},
                                       {"over the first body", true},
                                       {"scaled", true}},
                           .rows = {}};
    for (const auto &steps : all) {
        const auto &first = *std::ranges::find(all, steps.model, &studies::ScaledSteps::model);
        layout.rows.push_back({steps.model, steps.body, fmt::format("{:.3f}", milliseconds * steps.critical_time_step),
                               fmt::format("{:.3f}", milliseconds * steps.critical_time_step_of_rest),
                               fmt::format("{:.3f}", milliseconds * steps.scaled_critical_time_step),
                               fmt::format("{}", steps.num_scaled_nodes), fmt::format("{:.1f}", steps.largest_factor),
                               fmt::format("{:.4f}", -percent * steps.first_change),
                               fmt::format("{:.3f}", -percent * steps.largest_change),
                               fmt::format("{:.0f}", microseconds * steps.seconds_per_step),
                               fmt::format("{:.0f}", microseconds * steps.scaled_seconds_per_step),
                               fmt::format("{:.4f}", steps.cost()), fmt::format("{:.4f}", steps.scaled_cost()),
                               fmt::format("{:.2f}", steps.cost() / first.cost()),
                               fmt::format("{:.2f}", steps.scaled_cost() / first.cost())});
    }
    return layout;
}

/// Which nodes ask for short steps, and what steps of a length of their own there would cost at least.
results::Layout local_steps_table(const std::vector<studies::ScaledSteps> &all) {
    results::Layout layout{.columns = {{"model"},
                                       {"body"},
                                       {"nodes of rate 1", true},
                                       {"2", true},
                                       {"4", true},
                                       {"8 and more", true},
                                       {"tetrahedra at stiff nodes [%]", true},
                                       {"with a ring [%]", true},
                                       {"small steps", true},
                                       {"passes, at least", true},
                                       {"with a ring", true}},
                           .rows = {}};
    for (const auto &steps : all) {
        const double small_steps = std::ceil(steps.critical_time_step_of_rest / steps.critical_time_step - 1e-9);
        const auto passes = [&](double part) { return fmt::format("{:.2f}", 1.0 + (small_steps - 1.0) * part); };
        auto &row = layout.rows.emplace_back(std::vector{steps.model, steps.body});
        for (const auto number : steps.nodes_of_rate)
            row.push_back(fmt::format("{}", number));
        row.push_back(fmt::format("{:.1f}", percent * steps.tetrahedra_at_stiff_nodes));
        row.push_back(fmt::format("{:.1f}", percent * steps.tetrahedra_with_a_ring));
        row.push_back(fmt::format("{:.0f}", small_steps));
        row.push_back(passes(steps.tetrahedra_at_stiff_nodes));
        row.push_back(passes(steps.tetrahedra_with_a_ring));
    }
    return layout;
}

int print_scaled_steps(const studies::StabilityOptions &options, bool markdown) {
    const auto found = studies::find_scaled_steps(options, print_progress());
    for (const auto &layout : {scaled_steps_table(found), local_steps_table(found)})
        fmt::print("{}\n", table_text(layout, markdown));
    return 0;
}

int print_stability(const studies::StabilityOptions &options, bool markdown, const std::string &command_line) {
    const auto found = studies::find_stability(options, command_line, print_progress());
    print_notes(found.notes);
    for (const auto &stability : found.records)
        print(stability, markdown);
    print_legend(found.records, !options.no_observed);
    for (const auto &stability : found.records)
        fmt::print("{}{}\n", markdown ? "- " : "", results::step_advice(stability, msm::default_safety_factor));
    fmt::print(stderr, "Result files are in {}\n", options.output);
    if (std::ranges::all_of(found.records, studies::is_as_predicted))
        return 0;
    fmt::print(stderr, "livermark: failed: an observed step differs from the predicted one by more than {:g} %\n",
               percent * studies::largest_difference);
    return 1;
}

} // namespace

Command add_modes(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand("modes", "Find the lowest frequencies and modes of constrained bodies");
    auto options = std::make_shared<studies::ModesOptions>();
    auto markdown = std::make_shared<bool>(false);
    add_bodies(*command, options->bodies);
    add_constraints(*command, options->load_case);
    command->add_option("--model", options->models, "Models that can compute their modes")->capture_default_str();
    command->add_option("--count", options->count, "Number of modes")
        ->check(CLI::Range(1, studies::most_modes))
        ->capture_default_str();
    add_materials(*command, options->material);
    add_output(*command, options->output, "Folder for <body>/modes.<load case>.h5");
    command->add_flag("--markdown", *markdown, "Print the tables in Markdown");
    return [=] { return print_modes(*options, *markdown, command_line); };
}

Command add_stability(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "stability", "Find the longest stable time step of the springs of a body: predicted from their largest "
                     "frequency, and observed in runs");
    auto options = std::make_shared<studies::StabilityOptions>();
    auto markdown = std::make_shared<bool>(false), mass_scaling = std::make_shared<bool>(false);
    add_bodies(*command, options->bodies);
    auto *law = command->add_option("--law", options->law, "A name as in 'livermark list spring-laws'");
    law->capture_default_str();
    auto *models = command->add_option("--model", options->models,
                                       "Models of springs, as in 'livermark list models', in place of a law");
    models->excludes(law);
    add_constraints(*command, options->load_case);
    command->add_option("--integrator", options->integrators,
                        "Names as in 'livermark list integrators'; by default all");
    command->add_option("--damping-ratio", options->damping_ratio, "Damping over critical damping, at two frequencies")
        ->check(number_not_below_zero())
        ->capture_default_str();
    command->add_option("--damping-frequencies", options->damping_frequencies, "The two frequencies [Hz]")
        ->check(positive_number())
        ->capture_default_str();
    add_materials(*command, options->material);
    add_output(*command, options->output, "Folder for <body>/stability.<law or model>.h5");
    command->add_flag("--markdown", *markdown, "Print the tables in Markdown");
    command->add_flag("--no-observed", options->no_observed, "Only predict, without runs: quicker");
    command
        ->add_flag(
            "--mass-scaling", *mass_scaling,
            "Print the effect of selective mass scaling on the arena's springs instead: steps, cost on one core, "
            "and the nodes that need short steps")
        ->excludes(models);
    return [=] {
        options->bodies = with_images_meshed(options->bodies, command_line);
        return *mass_scaling ? print_scaled_steps(*options, *markdown)
                             : print_stability(*options, *markdown, command_line);
    };
}

} // namespace livermark::cli
