#include "results/hdf5/arena_file.hpp"

#include <fmt/format.h>
#include <vector>

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/hdf5_io.hpp"
#include "support/whole_file.hpp"

namespace livermark::results {

namespace {

using hdf5::InputFile;
using hdf5::OutputFile;

constexpr const char *group = "/arena";

std::string path_of(const char *name) {
    return fmt::format("{}/{}", group, name);
}

/// A column of numbers, and where it is in a row.
struct NumberColumn {
    const char *name;
    const char *units;
    double &(*value)(ArenaRun &);
};

const std::vector<NumberColumn> &number_columns() {
    static const std::vector<NumberColumn> columns{
        {"budget", "s", [](ArenaRun &run) -> double & { return run.budget; }},
        {"contact_error", "", [](ArenaRun &run) -> double & { return run.errors.contact; }},
        {"after_error", "", [](ArenaRun &run) -> double & { return run.errors.after; }},
        {"force_error", "", [](ArenaRun &run) -> double & { return run.errors.force; }},
        {"volume_error", "", [](ArenaRun &run) -> double & { return run.volume_error; }},
        {"smallest_jacobian", "", [](ArenaRun &run) -> double & { return run.smallest_jacobian; }},
        {"frame_seconds", "s", [](ArenaRun &run) -> double & { return run.frame_seconds; }},
        {"frame_seconds_95", "s", [](ArenaRun &run) -> double & { return run.frame_seconds_95; }},
        {"worst_frame_seconds", "s", [](ArenaRun &run) -> double & { return run.worst_frame_seconds; }},
        {"setup_seconds", "s", [](ArenaRun &run) -> double & { return run.setup_seconds; }},
        {"release_seconds", "s", [](ArenaRun &run) -> double & { return run.release_seconds; }},
        {"element_passes", "", [](ArenaRun &run) -> double & { return run.element_passes; }},
        {"bytes_per_element", "", [](ArenaRun &run) -> double & { return run.bytes_per_element; }}};
    return columns;
}

struct CountColumn {
    const char *name;
    int &(*value)(ArenaRun &);
};

const std::vector<CountColumn> &count_columns() {
    static const std::vector<CountColumn> columns{
        {"tetrahedra", [](ArenaRun &run) -> int & { return run.tetrahedra; }},
        {"steps", [](ArenaRun &run) -> int & { return run.steps; }},
        {"iterations", [](ArenaRun &run) -> int & { return run.iterations; }},
        {"num_inverted", [](ArenaRun &run) -> int & { return run.num_inverted; }}};
    return columns;
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
    auto runs = arena.runs; // columns are references
    for (const auto &column : number_columns()) {
        std::vector<double> values;
        for (auto &run : runs)
            values.push_back(column.value(run));
        file.dataset(path_of(column.name), values, column.units);
    }
    for (const auto &column : count_columns()) {
        std::vector<int> values;
        for (auto &run : runs)
            values.push_back(column.value(run));
        file.dataset(path_of(column.name), values, "");
    }
    if (arena.runs.empty())
        return support::write_whole(path, file.image());
    file.blocks(path_of("force"), joined<core::Vector3>(arena.runs, [](const ArenaRun &run) { return run.force; }),
                arena.time.size(), "N");
    file.blocks(path_of("error_over_time"),
                joined<double>(arena.runs, [](const ArenaRun &run) { return run.errors.over_time; }),
                arena.runs.front().errors.over_time.size(), "");
    support::write_whole(path, file.image());
}

Arena read_arena(const std::filesystem::path &path) {
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
    arena.reference_force = file.dataset<core::Vector3>(path_of("reference_force"), arena.time.size());
    const auto methods = file.texts(group, "methods"), settings = file.texts(group, "settings"),
               outcomes = file.texts(group, "outcomes");
    if (settings.size() != methods.size() || outcomes.size() != methods.size())
        file.refuse(group, "has not as many settings and outcomes as methods");
    arena.runs.resize(methods.size());
    for (std::size_t r = 0; r < methods.size(); ++r) {
        arena.runs[r].method = methods[r];
        arena.runs[r].setting = settings[r];
        for (const auto outcome : {ArenaOutcome::too_slow, ArenaOutcome::diverged})
            if (outcomes[r] == to_string(outcome))
                arena.runs[r].outcome = outcome;
    }
    for (const auto &column : number_columns()) {
        const auto values = file.dataset<double>(path_of(column.name), methods.size());
        for (std::size_t r = 0; r < methods.size(); ++r)
            column.value(arena.runs[r]) = values[r];
    }
    for (const auto &column : count_columns()) {
        const auto values = file.dataset<int>(path_of(column.name), methods.size());
        for (std::size_t r = 0; r < methods.size(); ++r)
            column.value(arena.runs[r]) = values[r];
    }
    if (methods.empty())
        return arena;
    const auto force = file.blocks<core::Vector3>(path_of("force"), methods.size(), arena.time.size());
    const std::size_t num_fields = (arena.time.size() - 1) / core::ToolHistory::frames_per_field + 1;
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

} // namespace livermark::results
