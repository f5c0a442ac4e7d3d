#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "app/cli/commands.hpp"
#include "app/cli/image_bodies.hpp"
#include "core/support/input_error.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "core/units.hpp"
#include "msm/engine_parameters.hpp"
#include "results/tables/table.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/exchange/engine_springs.hpp"

namespace livermark::cli {

namespace {

using core::percent;

results::Layout settings_table(const msm::EngineParameters &parameters) {
    results::Layout layout{{{"setting"}, {"value", true}, {"unit"}, {"what it is"}}, {}};
    for (const auto &[name, value, unit, meaning] : parameters.settings)
        layout.rows.push_back({name, fmt::format("{:.6g}", value), unit.empty() ? "-" : unit, meaning});
    return layout;
}

results::Layout arrays_table(const msm::EngineParameters &parameters) {
    results::Layout layout{
        {{"array"}, {"rows", true}, {"least", true}, {"median", true}, {"largest", true}, {"unit"}, {"what it is"}},
        {}};
    for (const auto &array : parameters.arrays) {
        std::vector<std::string> row{array.name, fmt::format("{}", array.rows()),       "-",          "-",
                                     "-",        array.unit.empty() ? "-" : array.unit, array.meaning};
        if (const auto *numbers = std::get_if<std::vector<double>>(&array.values);
            numbers && array.columns == 1 && !numbers->empty()) {
            auto sorted = *numbers;
            std::ranges::sort(sorted);
            row[2] = fmt::format("{:.3g}", sorted.front());
            row[3] = fmt::format("{:.3g}", sorted[sorted.size() / 2]);
            row[4] = fmt::format("{:.3g}", sorted.back());
        }
        layout.rows.push_back(std::move(row));
    }
    return layout;
}

void print_errors(const std::string &engine, const std::optional<studies::EngineErrors> &errors, bool markdown) {
    if (!errors) {
        fmt::print("Expected error: not measured, because results/engines has no entry of {}\n", engine);
        return;
    }
    results::Layout layout{{{"expected error"}, {"median [%]", true}, {"worst [%]", true}, {"problems", true}}, {}};
    const auto add = [&](const char *title, const studies::ErrorRange &range) {
        if (range.number == 0)
            layout.rows.push_back({title, "not measured", "-", "0"});
        else
            layout.rows.push_back({title, fmt::format("{:.1f}", percent * range.median),
                                   fmt::format("{:+.1f}", percent * range.worst), fmt::format("{}", range.number)});
    };
    add("position, at rest (L2)", errors->relative_l2);
    add("stiffness at the tool, at rest", errors->stiffness_at_tool);
    add("position, in motion and in contact", errors->in_contact);
    add("force, in motion", errors->force);
    fmt::print("{}\nMeasured with {} {}{}{}", table_text(layout, markdown), engine, errors->version,
               errors->settings.empty() ? "" : ", " + results::printable(errors->settings),
               errors->machine.empty() ? "" : " on " + results::printable(errors->machine));
    if (errors->num_failed > 0)
        fmt::print("; {} of {} problems have no score", errors->num_failed, errors->num_problems);
    fmt::print("\n");
}

int print_engine_springs(studies::EngineSpringsOptions options, bool markdown, const std::string &command_line) {
    const auto &engine = support::find_named(msm::all_engines(), options.engine, "engine");
    options.body = with_image_meshed(options.body, command_line);
    const auto springs = studies::write_engine_springs(options, command_line);
    print_notes(springs.notes);
    const auto &parameters = springs.parameters;
    const char *bullet = markdown ? "- " : "  ";
    fmt::print("{} for {}: {}\n\n", results::printable(springs.body), engine.name, engine.summary);
    fmt::print("{}\n{}\n", table_text(settings_table(parameters), markdown),
               table_text(arrays_table(parameters), markdown));
    for (const auto &[title, sentences] : {std::pair{"How to use them", &parameters.notes},
                                           std::pair{"What this engine cannot do", &parameters.cannot}}) {
        fmt::print("{}:\n{}", title, markdown ? "\n" : "");
        for (const auto &sentence : *sentences)
            fmt::print("{}{}\n", bullet, results::printable(sentence));
        fmt::print("\n");
    }
    print_errors(engine.name, springs.errors, markdown);
    fmt::print("Formulas are of the sources of {}.\n", engine.sources);
    for (const auto &file : springs.files)
        fmt::print("{}\n", file.string());
    return 0;
}

} // namespace

Command add_springs(CLI::App &parent, const std::string &command_line) {
    const auto engines = support::names_of(msm::all_engines());
    auto *command = parent.add_subcommand(
        "springs", fmt::format("Write what brings an engine nearest to the tissue of a body: masses, stiffnesses or "
                               "compliances, volumes, constants to type in and substeps, with the error to expect. "
                               "Engines: {}",
                               fmt::join(engines, ", ")));
    auto options = std::make_shared<studies::EngineSpringsOptions>();
    auto markdown = std::make_shared<bool>(false);
    add_body(*command, options->body);
    command->add_option("--for", options->engine, fmt::format("The engine: {}", fmt::join(engines, ", ")))->required();
    add_materials(*command, options->material);
    command->add_option("--law", options->choices.law, "Law of the springs, as in 'livermark list spring-laws'")
        ->capture_default_str();
    command->add_option("--substeps", options->choices.substeps,
                        "Substeps or steps in a frame; by default what suits the engine");
    command->add_option("--frame", options->choices.frame, "Length of a frame [s]")
        ->check(positive_number())
        ->default_str("1/60");
    command->add_option("-o,--output", options->output, "Folder for <body>.<engine>.json")->capture_default_str();
    command->add_flag("--markdown", *markdown, "Print the tables in Markdown");
    return [=] { return print_engine_springs(*options, *markdown, command_line); };
}

} // namespace livermark::cli
