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

constexpr const char *calibration_spread = "calibration_spread";

/// Columns that files of 0.1.0 do not have.
constexpr std::array later_columns{"calibration_spread", "pressed_force", "slid_force", "slid_ratio", "deepest"};

bool is_later_column(std::string_view name) {
    return std::ranges::find(later_columns, name) != later_columns.end();
}

std::string path_of(const char *name) {
    return fmt::format("{}/{}", group, name);
}

/// Calls for each column of numbers with its name, its units, and a function to its number of a run.
template <class Visit> void for_each_column(Visit visit) {
    visit(
        "tetrahedra", "", [](auto &run) -> auto & { return run.tetrahedra; });
    visit(
        "budget", "s", [](auto &run) -> auto & { return run.budget; });
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
    std::vector<std::string> methods, settings, outcomes;
    for (const auto &run : arena.runs) {
        methods.push_back(run.method);
        settings.push_back(run.setting);
        outcomes.emplace_back(to_string(run.outcome));
    }
    file.texts(group, "methods", methods);
    file.texts(group, "settings", settings);
    file.texts(group, "outcomes", outcomes);
    for_each_column([&](const char *name, const char *units, auto number) {
        std::vector<std::remove_cvref_t<decltype(number(arena.runs.front()))>> values;
        std::ranges::transform(arena.runs, std::back_inserter(values), number);
        file.dataset(path_of(name), values, units);
    });
    if (arena.runs.empty())
        return support::write_whole(path, file.image());
    file.blocks(path_of("force"), joined<core::Vector3>(arena.runs, [](const ArenaRun &run) { return run.force; }),
                arena.time.size(), "N");
    file.blocks(path_of("error_over_time"),
                joined<double>(arena.runs, [](const ArenaRun &run) { return run.errors.over_time; }),
                arena.runs.front().errors.over_time.size(), "");
    support::write_whole(path, file.image());
}

namespace {

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
                .runs = {}};
    if (file.has_attribute(group, "tool")) { // files of 0.1.0 have none
        arena.tool = file.text(group, "tool");
        arena.friction = file.number(group, "friction");
        arena.ball_radius = file.number(group, "ball_radius");
    }
    arena.reference_force = file.dataset<core::Vector3>(path_of("reference_force"), arena.time.size());
    const auto methods = file.texts(group, "methods"), settings = file.texts(group, "settings"),
               outcomes = file.texts(group, "outcomes");
    if (settings.size() != methods.size() || outcomes.size() != methods.size())
        file.refuse(group, "has not as many settings and outcomes as methods");
    arena.runs.resize(methods.size());
    for (std::size_t r = 0; r < methods.size(); ++r) {
        arena.runs[r].method = methods[r];
        arena.runs[r].setting = settings[r];
        const auto outcome = outcome_of(outcomes[r]);
        if (!outcome)
            file.refuse(group, fmt::format("has an outcome '{}' that is not known", support::shown(outcomes[r])));
        arena.runs[r].outcome = *outcome;
    }
    for_each_column([&](const char *name, const char *, auto number) {
        using Number = std::remove_cvref_t<decltype(number(arena.runs.front()))>;
        if (is_later_column(name) && !file.has(path_of(name)))
            return;
        const auto values = file.dataset<Number>(path_of(name), methods.size());
        for (std::size_t r = 0; r < methods.size(); ++r)
            number(arena.runs[r]) = values[r];
    });
    if (methods.empty())
        return arena;
    const auto force = file.blocks<core::Vector3>(path_of("force"), methods.size(), arena.time.size());
    const std::size_t num_fields = core::ToolHistory::num_fields(static_cast<int>(arena.time.size()));
    const auto error = file.blocks<double>(path_of("error_over_time"), methods.size(), num_fields);
    for (std::size_t r = 0; r < methods.size(); ++r) {
        const auto from = static_cast<std::ptrdiff_t>(r * arena.time.size());
        arena.runs[r].force.assign(force.begin() + from, force.begin() + from + std::ssize(arena.time));
        const auto first = static_cast<std::ptrdiff_t>(r * num_fields);
        arena.runs[r].errors.over_time.assign(error.begin() + first,
                                              error.begin() + first + static_cast<std::ptrdiff_t>(num_fields));
    }
    return arena;
}

} // namespace

Arena read_arena(const std::filesystem::path &path) {
    return hdf5::read_once_tried(path, [&] { return arena_in(path); });
}

} // namespace livermark::results
