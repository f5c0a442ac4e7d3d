#include "studies/exchange/engine_springs.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <variant>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "results/records/result.hpp"
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

using Json = nlohmann::ordered_json;

std::string settings_text(const Json &settings) {
    std::string text;
    for (const auto &setting : settings.items())
        text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", setting.key(), setting.value().dump());
    return text;
}

/// An array as rows, or as numbers where it has one column.
Json json_of(const msm::EngineArray &array) {
    Json object{{"unit", array.unit}, {"meaning", array.meaning}, {"shape", {array.rows()}}};
    if (array.columns > 1)
        object["shape"].push_back(array.columns);
    std::visit(
        [&](const auto &values) {
            auto &rows = object["values"] = Json::array();
            if (array.columns == 1)
                rows = values;
            else
                for (std::size_t row = 0; row < array.rows(); ++row) {
                    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(array.columns * row);
                    rows.push_back(std::vector(begin, begin + static_cast<std::ptrdiff_t>(array.columns)));
                }
        },
        array.values);
    return object;
}

Json json_of(const ErrorRange &range) {
    if (range.number == 0)
        return nullptr;
    return {{"median", range.median}, {"worst", range.worst}, {"problems", range.number}};
}

Json json_of(const EngineErrors &errors) {
    return {{"version", errors.version},
            {"settings", errors.settings},
            {"machine", errors.machine},
            {"relative_l2", json_of(errors.relative_l2)},
            {"stiffness_at_tool", json_of(errors.stiffness_at_tool)},
            {"in_contact", json_of(errors.in_contact)},
            {"force", json_of(errors.force)},
            {"problems", errors.num_problems},
            {"failed", errors.num_failed}};
}

/// Members of an object on a line each: arrays are too long for a line a number.
std::string in_lines(const Json &object) {
    std::string text;
    for (const auto &member : object.items())
        text += fmt::format("{}{}: {}", text.empty() ? "" : ",\n ", Json(member.key()).dump(), member.value().dump());
    return '{' + text + '}';
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
    auto settings = Json::array(), arrays = Json::object();
    for (const auto &[name, value, unit, meaning] : parameters.settings)
        settings.push_back({{"name", name}, {"value", value}, {"unit", unit}, {"meaning", meaning}});
    for (const auto &array : parameters.arrays)
        arrays[array.name] = json_of(array);
    return in_lines({{"body", springs.body},
                     {"engine", parameters.engine},
                     {"software_version", provenance.software_version},
                     {"git_commit", provenance.git_commit},
                     {"created", provenance.created},
                     {"command", provenance.command},
                     {"settings", settings},
                     {"arrays", arrays},
                     {"notes", parameters.notes},
                     {"cannot", parameters.cannot},
                     {"errors", springs.errors ? json_of(*springs.errors) : Json()}}) +
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
