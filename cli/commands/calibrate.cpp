#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <numeric>

#include "cli/commands/commands.hpp"
#include "cli/common_options.hpp"
#include "cli/image_bodies.hpp"
#include "cli/progress.hpp"
#include "core/units.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/calibration/calibrate.hpp"

namespace livermark::cli {

namespace {

using core::percent;
double mean(const std::vector<double> &values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

void print_errors(const results::Calibration &calibration, bool markdown) {
    results::Layout table{{{"loads", false},
                           {"number", true},
                           {"mean before [%]", true},
                           {"worst before [%]", true},
                           {"mean after [%]", true},
                           {"worst after [%]", true}},
                          {}};
    for (const bool held_out : {false, true}) {
        std::vector<double> before, after;
        for (std::size_t l = 0; l < calibration.held_out.size(); ++l)
            if ((calibration.held_out[l] != 0) == held_out) {
                before.push_back(calibration.error_before[l]);
                after.push_back(calibration.error_after[l]);
            }
        const auto in_percent = [](double error) { return results::fixed(percent * error, 2); };
        table.rows.push_back({held_out ? "held out" : "training", fmt::format("{}", before.size()),
                              in_percent(mean(before)), in_percent(*std::ranges::max_element(before)),
                              in_percent(mean(after)), in_percent(*std::ranges::max_element(after))});
    }
    fmt::print("{}: relative L2 errors to {} after {} iterations from {}\n{}{}", calibration.body,
               calibration.reference, calibration.iterations, calibration.spring_law, markdown ? "\n" : "",
               markdown ? results::to_markdown(table) : results::to_text(table));
}

int calibrate(const studies::CalibrateOptions &options, bool markdown, const std::string &command_line) {
    const auto [calibration, file] = studies::calibrate(options, command_line, print_progress());
    print_errors(calibration, markdown);
    fmt::print(stderr, "The calibration is in {}\n", file.string());
    return 0;
}

} // namespace

Command add_calibrate(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "calibrate", "Fit the stiffness of every spring of a body to finite element solutions under random loads");
    auto options = std::make_shared<studies::CalibrateOptions>();
    auto markdown = std::make_shared<bool>(false);
    add_body(*command, options->body);
    command->add_option("--law", options->law, "The spring law to start from")->capture_default_str();
    command->add_option("--constrained", options->constrained, "The patch where the body is constrained")
        ->capture_default_str();
    command
        ->add_option("--loads", options->num_loads,
                     "Number of loads; every fourth one is left out of the fit, as a test")
        ->check(CLI::Range(studies::held_out_stride, 1000))
        ->capture_default_str();
    command->add_option("--seed", options->seed, "Seed of the random loads")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    command
        ->add_option("--iterations", options->num_iterations,
                     "Evaluations of the objective in total, including those of earlier calls; a multiple of 20")
        ->check([](const std::string &text) {
            int value = 0;
            return CLI::detail::lexical_cast(text, value) && value >= studies::round_length &&
                           value % studies::round_length == 0
                       ? ""
                       : fmt::format("takes a multiple of {}", studies::round_length);
        })
        ->capture_default_str();
    command
        ->add_option("--penalty", options->penalty,
                     "Weight of the mean square of ln(k / start) beside the mean square relative error")
        ->check(CLI::Range(0.0, 1e6))
        ->capture_default_str();
    add_materials(*command, options->material);
    command->add_option("--output", options->output,
                        "The file to write or to continue; by default <body>.calibrated.h5 beside the body's .toml");
    command->add_flag("--restart", options->restart, "Start again even if the file exists");
    command->add_flag("--markdown", *markdown, "Print the table in Markdown");
    return [=] {
        options->body = with_image_meshed(options->body, command_line);
        return calibrate(*options, *markdown, command_line);
    };
}

} // namespace livermark::cli
