#include "results/hdf5/files/arena_file.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <iterator>
#include <optional>
#include <string_view>
#include <type_traits>
#include <vector>

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/hdf5_io.hpp"
#include "results/hdf5/io/read_apart.hpp"
#include "support/input_error.hpp"
#include "support/whole_file.hpp"

namespace livermark::results {

namespace {

using hdf5::InputFile;
using hdf5::OutputFile;

constexpr const char *group = "/arena";
constexpr const char *series_group = "/series";   ///< of files since 0.2.0, as the one below
constexpr const char *methods_group = "/methods"; ///< what there is to say of methods

constexpr const char *budget = "budget", *calibration_spread = "calibration_spread";

/// Columns that files of 0.1.0 do not have.
constexpr std::array later_columns{"calibration_spread", "pressed_force", "slid_force", "slid_ratio", "deepest"};

bool is_later_column(std::string_view name) {
    return std::ranges::find(later_columns, name) != later_columns.end();
}

std::string path_of(const char *name, const char *in = group) {
    return fmt::format("{}/{}", in, name);
}

/// Runs with given iterations have no budget, so nothing was measured to keep to it.
bool has_column(const char *in, std::string_view name) {
    return in == group || (name != budget && name != calibration_spread);
}

/// Calls for each column of numbers with its name, its units, and a function to its number of a run.
template <class Visit> void for_each_column(Visit visit) {
    visit(
        "tetrahedra", "", [](auto &run) -> auto & { return run.tetrahedra; });
    visit(
        budget, "s", [](auto &run) -> auto & { return run.budget; });
    visit(
        "steps", "", [](auto &run) -> auto & { return run.steps; });
    visit(
        "iterations", "", [](auto &run) -> auto & { return run.iterations; });
    visit(
        "contact_error", "", [](auto &run) -> auto & { return run.errors.contact; });
    visit(
        "after_error", "", [](auto &run) -> auto & { return run.errors.after; });
    visit(
        "force_error", "", [](auto &run) -> auto & { return run.errors.force; });
    visit(
        "volume_error", "", [](auto &run) -> auto & { return run.volume_error; });
    visit(
        "smallest_jacobian", "", [](auto &run) -> auto & { return run.smallest_jacobian; });
    visit(
        "num_inverted", "", [](auto &run) -> auto & { return run.num_inverted; });
    visit(
        "frame_seconds", "s", [](auto &run) -> auto & { return run.frame_seconds; });
    visit(
        "frame_seconds_95", "s", [](auto &run) -> auto & { return run.frame_seconds_95; });
    visit(
        "worst_frame_seconds", "s", [](auto &run) -> auto & { return run.worst_frame_seconds; });
    visit(
        "setup_seconds", "s", [](auto &run) -> auto & { return run.setup_seconds; });
    visit(
        "release_seconds", "s", [](auto &run) -> auto & { return run.release_seconds; });
    visit(
        "element_passes", "", [](auto &run) -> auto & { return run.element_passes; });
    visit(
        "bytes_per_element", "", [](auto &run) -> auto & { return run.bytes_per_element; });
    visit(
        calibration_spread, "", [](auto &run) -> auto & { return run.calibration_spread; });
    visit(
        "pressed_force", "N", [](auto &run) -> auto & { return run.pressed_force; });
    visit(
        "slid_force", "N", [](auto &run) -> auto & { return run.slid_force; });
    visit(
        "slid_ratio", "", [](auto &run) -> auto & { return run.slid_ratio; });
    visit(
        "deepest", "m", [](auto &run) -> auto & { return run.deepest; });
}

std::optional<ArenaOutcome> outcome_of(const std::string &word) {
    for (const auto outcome : {ArenaOutcome::ok, ArenaOutcome::too_slow, ArenaOutcome::diverged})
        if (word == to_string(outcome))
            return outcome;
    return std::nullopt;
}

/// Rows of all runs, one behind the other.
template <class T> std::vector<T> joined(const std::vector<ArenaRun> &runs, std::vector<T> (*rows)(const ArenaRun &)) {
    std::vector<T> all;
    for (const auto &run : runs)
        for (const auto &row : rows(run))
            all.push_back(row);
    return all;
}

/// @param num_records  K
void write_runs(OutputFile &file, const char *in, const std::vector<ArenaRun> &runs, std::size_t num_records) {
    std::vector<std::string> methods, settings, outcomes;
    for (const auto &run : runs) {
        methods.push_back(run.method);
        settings.push_back(run.setting);
        outcomes.emplace_back(to_string(run.outcome));
    }
    file.texts(in, "methods", methods);
    file.texts(in, "settings", settings);
    file.texts(in, "outcomes", outcomes);
    for_each_column([&](const char *name, const char *units, auto number) {
        if (!has_column(in, name))
            return;
        std::vector<std::remove_cvref_t<decltype(number(runs.front()))>> values;
        std::ranges::transform(runs, std::back_inserter(values), number);
        file.dataset(path_of(name, in), values, units);
    });
    if (runs.empty())
        return;
    file.blocks(path_of("force", in), joined<core::Vector3>(runs, [](const ArenaRun &run) { return run.force; }),
                num_records, "N");
    file.blocks(path_of("error_over_time", in),
                joined<double>(runs, [](const ArenaRun &run) { return run.errors.over_time; }),
                runs.front().errors.over_time.size(), "");
}

/// Calls for each text of a method with its name, and a function to it.
template <class Visit> void for_each_text(Visit visit) {
    visit("names", &ArenaMethod::name);
    visit("sources", &ArenaMethod::source);
    visit("implementations", &ArenaMethod::implementation);
    visit("converge_to", &ArenaMethod::converges_to);
    visit("objections", &ArenaMethod::objection);
}

} // namespace

void write_arena(const std::filesystem::path &path, const Arena &arena) {
    OutputFile file;
    hdf5::write_provenance(file, arena.provenance);
    file.text("/", "body", arena.body);
    file.text("/", "load_case", arena.load_case);
    file.text("/", "title", arena.title);
    file.group(group);
    file.number(group, "frame_interval", arena.frame_interval);
    file.text(group, "tool", arena.tool);
    file.number(group, "friction", arena.friction);
    file.number(group, "ball_radius", arena.ball_radius);
    file.text(group, "reference", arena.reference);
    file.number(group, "reference_contact_change", arena.reference_errors.contact);
    file.number(group, "reference_after_change", arena.reference_errors.after);
    file.number(group, "reference_force_change", arena.reference_errors.force);
    file.dataset(path_of("time"), arena.time, "s");
    file.dataset(path_of("reference_force"), arena.reference_force, "N");
    file.number(group, "reference_pressed_force", arena.reference_pressed_force);
    write_runs(file, group, arena.runs, arena.time.size());
    if (!arena.series.empty()) {
        file.group(series_group);
        write_runs(file, series_group, arena.series, arena.time.size());
    }
    if (!arena.methods.empty()) {
        file.group(methods_group);
        for_each_text([&](const char *name, std::string ArenaMethod::*text) {
            std::vector<std::string> texts;
            std::ranges::transform(arena.methods, std::back_inserter(texts),
                                   [&](const ArenaMethod &method) { return method.*text; });
            file.texts(methods_group, name, texts);
        });
    }
    support::write_whole(path, file.image());
}

namespace {

std::vector<ArenaRun> runs_in(const InputFile &file, const char *in, std::size_t num_records) {
    const auto methods = file.texts(in, "methods"), settings = file.texts(in, "settings"),
               outcomes = file.texts(in, "outcomes");
    if (settings.size() != methods.size() || outcomes.size() != methods.size())
        file.refuse(in, "has not as many settings and outcomes as methods");
    std::vector<ArenaRun> runs(methods.size());
    for (std::size_t r = 0; r < methods.size(); ++r) {
        runs[r].method = methods[r];
        runs[r].setting = settings[r];
        const auto outcome = outcome_of(outcomes[r]);
        if (!outcome)
            file.refuse(in, fmt::format("has an outcome '{}' that is not known", support::shown(outcomes[r])));
        runs[r].outcome = *outcome;
    }
    for_each_column([&](const char *name, const char *, auto number) {
        using Number = std::remove_cvref_t<decltype(number(runs.front()))>;
        if (!has_column(in, name) || (is_later_column(name) && !file.has(path_of(name, in))))
            return;
        const auto values = file.dataset<Number>(path_of(name, in), methods.size());
        for (std::size_t r = 0; r < methods.size(); ++r)
            number(runs[r]) = values[r];
    });
    if (methods.empty())
        return runs;
    const auto force = file.blocks<core::Vector3>(path_of("force", in), methods.size(), num_records);
    const std::size_t num_fields = core::ToolHistory::num_fields(static_cast<int>(num_records));
    const auto error = file.blocks<double>(path_of("error_over_time", in), methods.size(), num_fields);
    for (std::size_t r = 0; r < methods.size(); ++r) {
        const auto from = static_cast<std::ptrdiff_t>(r * num_records);
        runs[r].force.assign(force.begin() + from, force.begin() + from + static_cast<std::ptrdiff_t>(num_records));
        const auto first = static_cast<std::ptrdiff_t>(r * num_fields);
        runs[r].errors.over_time.assign(error.begin() + first,
                                        error.begin() + first + static_cast<std::ptrdiff_t>(num_fields));
    }
    return runs;
}

std::vector<ArenaMethod> methods_in(const InputFile &file) {
    std::vector<ArenaMethod> methods(file.texts(methods_group, "names").size());
    for_each_text([&](const char *name, std::string ArenaMethod::*text) {
        const auto texts = file.texts(methods_group, name);
        if (texts.size() != methods.size())
            file.refuse(methods_group, fmt::format("has not as many {} as names", name));
        for (std::size_t m = 0; m < methods.size(); ++m)
            methods[m].*text = texts[m];
    });
    return methods;
}

Arena arena_in(const std::filesystem::path &path) {
    const InputFile file(path, "livermark arena");
    hdf5::check_schema(file);
    Arena arena{.provenance = hdf5::read_provenance(file),
                .body = file.text("/", "body"),
                .load_case = file.text("/", "load_case"),
                .title = file.text("/", "title"),
                .reference = file.text(group, "reference"),
                .frame_interval = file.number(group, "frame_interval"),
                .time = file.dataset<double>(path_of("time")),
                .reference_force = {},
                .reference_errors = {.contact = file.number(group, "reference_contact_change"),
                                     .after = file.number(group, "reference_after_change"),
                                     .force = file.number(group, "reference_force_change"),
                                     .over_time = {}},
                .runs = {},
                .series = {},
                .methods = {}};
    if (file.has_attribute(group, "tool")) { // files of 0.1.0 have none
        arena.tool = file.text(group, "tool");
        arena.friction = file.number(group, "friction");
        arena.ball_radius = file.number(group, "ball_radius");
    }
    arena.reference_force = file.dataset<core::Vector3>(path_of("reference_force"), arena.time.size());
    if (file.has_attribute(group, "reference_pressed_force"))
        arena.reference_pressed_force = file.number(group, "reference_pressed_force");
    arena.runs = runs_in(file, group, arena.time.size());
    if (file.has(series_group))
        arena.series = runs_in(file, series_group, arena.time.size());
    if (file.has(methods_group))
        arena.methods = methods_in(file);
    return arena;
}

} // namespace

Arena read_arena(const std::filesystem::path &path) {
    return hdf5::read_once_tried(path, [&] { return arena_in(path); });
}

} // namespace livermark::results
