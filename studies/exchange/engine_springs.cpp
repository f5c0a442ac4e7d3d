#include "studies/exchange/engine_springs.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <sstream>
#include <toml++/toml.h>
#include <utility>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "results/records/result.hpp"
#include "studies/exchange/formats/json_text.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

namespace {

/// Errors of the problems that were scored, where they are known.
ErrorRange range_of(const results::EngineEntry &entry, double results::EngineProblem::*error) {
    std::vector<double> known;
    for (const auto &problem : entry.problems)
        if (problem.is_scored() && !std::isnan(problem.*error))
            known.push_back(problem.*error);
    if (known.empty())
        return {};
    std::ranges::sort(known, {}, [](double value) { return std::abs(value); });
    const auto middle = known.size() / 2;
    const double median =
        known.size() % 2 == 1 ? std::abs(known[middle]) : 0.5 * (std::abs(known[middle - 1]) + std::abs(known[middle]));
    return {median, known.back(), known.size()};
}

std::string settings_text(const toml::table &settings) {
    std::string text;
    for (const auto &[name, value] : settings) {
        std::ostringstream shown;
        value.visit([&](const auto &node) { shown << node; });
        const auto number = value.value_exact<double>();
        text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", name.str(),
                            number ? fmt::format("{}", *number) : shown.str());
    }
    return text;
}

using exchange::json;

/// An array as rows, or as numbers where it has one column.
std::string json_rows(const msm::EngineArray &array) {
    return std::visit(
        [&](const auto &values) {
            if (array.columns == 1)
                return json(values);
            std::string rows;
            for (std::size_t row = 0; row < array.rows(); ++row) {
                rows += row == 0 ? "[" : ",[";
                for (std::size_t c = 0; c < array.columns; ++c)
                    rows += (c == 0 ? "" : ",") + json(values[array.columns * row + c]);
                rows += ']';
            }
            return '[' + rows + ']';
        },
        array.values);
}

std::string json_object(const std::vector<std::pair<std::string, std::string>> &members, const char *between) {
    std::string text;
    for (const auto &[name, value] : members)
        text += fmt::format("{}{}: {}", text.empty() ? "" : between, json(name), value);
    return '{' + text + '}';
}

std::string json_range(const ErrorRange &range) {
    if (range.number == 0)
        return "null";
    return json_object({{"median", json(range.median)},
                        {"worst", json(range.worst)},
                        {"problems", json(static_cast<int>(range.number))}},
                       ", ");
}

std::string json_errors(const std::optional<EngineErrors> &errors) {
    if (!errors)
        return "null";
    return json_object({{"version", json(errors->version)},
                        {"settings", json(errors->settings)},
                        {"machine", json(errors->machine)},
                        {"relative_l2", json_range(errors->relative_l2)},
                        {"stiffness_at_tool", json_range(errors->stiffness_at_tool)},
                        {"in_contact", json_range(errors->in_contact)},
                        {"force", json_range(errors->force)},
                        {"problems", json(static_cast<int>(errors->num_problems))},
                        {"failed", json(static_cast<int>(errors->num_failed))}},
                       ", ");
}

} // namespace

EngineErrors errors_of(const results::EngineEntry &entry) {
    using Problem = results::EngineProblem;
    EngineErrors errors{.version = entry.version,
                        .machine = entry.machine,
                        .settings = settings_text(entry.settings),
                        .relative_l2 = range_of(entry, &Problem::relative_l2),
                        .stiffness_at_tool = range_of(entry, &Problem::stiffness_at_tool),
                        .in_contact = range_of(entry, &Problem::in_contact),
                        .force = range_of(entry, &Problem::force),
                        .num_problems = entry.problems.size()};
    errors.num_failed = static_cast<std::size_t>(
        std::ranges::count_if(entry.problems, [](const Problem &problem) { return !problem.is_scored(); }));
    return errors;
}

std::optional<EngineErrors> measured_errors(const std::string &engine) {
    const auto file = support::root_folder() / engines_folder / (engine + ".json");
    if (!std::filesystem::exists(file))
        return {};
    return errors_of(results::read_engine_entry(file));
}

std::string engine_springs_text(const EngineSprings &springs, const std::string &command_line) {
    const auto &parameters = springs.parameters;
    const auto provenance = results::current_provenance(command_line);
    std::vector<std::string> settings;
    for (const auto &[name, value, unit, meaning] : parameters.settings)
        settings.push_back(json_object(
            {{"name", json(name)}, {"value", json(value)}, {"unit", json(unit)}, {"meaning", json(meaning)}}, ", "));
    std::vector<std::pair<std::string, std::string>> arrays;
    for (const auto &array : parameters.arrays) {
        const auto shape = array.columns == 1 ? fmt::format("[{}]", array.rows())
                                              : fmt::format("[{}, {}]", array.rows(), array.columns);
        arrays.emplace_back(array.name, json_object({{"unit", json(array.unit)},
                                                     {"meaning", json(array.meaning)},
                                                     {"shape", shape},
                                                     {"values", json_rows(array)}},
                                                    ", "));
    }
    std::string listed;
    for (const auto &setting : settings)
        listed += (listed.empty() ? "\n  " : ",\n  ") + setting;
    return json_object({{"body", json(springs.body)},
                        {"engine", json(parameters.engine)},
                        {"software_version", json(provenance.software_version)},
                        {"git_commit", json(provenance.git_commit)},
                        {"created", json(provenance.created)},
                        {"command", json(provenance.command)},
                        {"settings", '[' + listed + ']'},
                        {"arrays", json_object(arrays, ",\n  ")},
                        {"notes", json(parameters.notes)},
                        {"cannot", json(parameters.cannot)},
                        {"errors", json_errors(springs.errors)}},
                       ",\n ") +
           '\n';
}

EngineSprings write_engine_springs(const EngineSpringsOptions &options, const std::string &command_line) {
    support::find_named(msm::all_engines(), options.engine, "engine");
    const auto body_file = find_toml_files({options.body}, bodies_folder, "body").front();
    const auto body = meshes::read_body(body_file, options.material);
    EngineSprings springs{.body = body.name,
                          .parameters = msm::engine_parameters(body, options.engine, options.choices),
                          .errors = measured_errors(options.engine),
                          .files = {},
                          .notes = body.assumptions};
    const OutputFolder folder(options.output);
    const auto write = [&](const std::string &ending, const std::string &text) {
        const auto file = folder.path() / (body.name + '.' + options.engine + ending);
        support::write_whole(file, text);
        springs.files.push_back(file);
    };
    write(".json", engine_springs_text(springs, command_line));
    if (springs.parameters.text)
        write(springs.parameters.text->ending, springs.parameters.text->text);
    return springs;
}

} // namespace livermark::studies
