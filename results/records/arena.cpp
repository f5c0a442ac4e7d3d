#include "results/records/arena.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <set>
#include <tuple>

#include "core/units.hpp"
#include "results/hdf5/record_file.hpp"

namespace livermark::results {

namespace {

using hdf5::Of;

std::string in_percent(double value) {
    return std::isfinite(value) ? fixed(core::percent * value, 1) : "-";
}

std::string in_milliseconds(double seconds) {
    return fixed(core::milliseconds * seconds, seconds < 0.1 ? 2 : 0); // "-" where somebody else does not say it
}

/// "-" where somebody else does not say it.
std::string count_or_dash(double count) {
    return fixed(count > 0.0 ? count : std::numeric_limits<double>::quiet_NaN(), 0);
}

/// Runs with given iterations have no budget, so nothing was measured to keep to it.
enum class Effort { of_budget, given };

/// @param num_records  K
template <class At>
void describe_arena_runs(At at, Of<At, std::vector<ArenaRun>> &runs, std::size_t num_records, Effort effort) {
    using Run = ArenaRun;
    const auto error = [](auto value) { return hdf5::inside(&Run::errors, value); };
    auto columns = hdf5::columns_of(at, runs);
    const auto later_column = [&](const char *name, auto value, const char *units, const hdf5::Shown<Run> &shown = {}) {
        if (at.has(name)) // not in files of 0.1.0
            columns.column(name, value, units, shown);
    };
    columns.texts("methods", &Run::method, "method");
    columns.texts("settings", &Run::setting, "setting");
    columns.words("outcomes", &Run::outcome, "outcome");
    columns.column("tetrahedra", &Run::tetrahedra, "", "tetrahedra");
    if (effort == Effort::of_budget)
        columns.column("budget", &Run::budget, "s", {"budget [ms]", in_milliseconds});
    columns.column("steps", &Run::steps, "", {"steps", count_or_dash});
    columns.column("iterations", &Run::iterations, "",
                   {"iterations", [](const Run &run) {
                        return run.iterations > 0 ? iterations_of(run.iterations, run.stops_early) : "-";
                    }});
    columns.column("contact_error", error(&core::ToolErrors::contact), "", {"contact [%]", in_percent});
    columns.column("after_error", error(&core::ToolErrors::after), "", {"after [%]", in_percent});
    columns.column("force_error", error(&core::ToolErrors::force), "", {"force [%]", in_percent});
    columns.column("volume_error", &Run::volume_error, "", {"volume [%]", core::percent, 2});
    columns.column("smallest_jacobian", &Run::smallest_jacobian, "", {"least J", 1.0, 2});
    columns.column("num_inverted", &Run::num_inverted);
    columns.column("frame_seconds", &Run::frame_seconds, "s", {"frame [ms]", in_milliseconds});
    columns.column("frame_seconds_95", &Run::frame_seconds_95, "s", {"95 % [ms]", in_milliseconds});
    columns.column("worst_frame_seconds", &Run::worst_frame_seconds, "s", {"worst [ms]", in_milliseconds});
    columns.column("setup_seconds", &Run::setup_seconds, "s", {"setup [s]", 1.0, 2});
    columns.column("release_seconds", &Run::release_seconds, "s");
    columns.column("element_passes", &Run::element_passes, "", {"passes", [](const Run &run) {
                                                                    return (run.stops_early != 0 ? "up to " : "") +
                                                                           count_or_dash(run.element_passes);
                                                                }});
    columns.column("bytes_per_element", &Run::bytes_per_element, "", {"B/tetrahedron", count_or_dash});
    if (effort == Effort::of_budget) {
        later_column("calibration_spread", &Run::calibration_spread, "");
        later_column("stops_early", &Run::stops_early, "");
    }
    later_column("pressed_force", &Run::pressed_force, "N", {"pressed [N]", 1.0, 3});
    later_column("slid_force", &Run::slid_force, "N", {"sliding [N]", 1.0, 3});
    later_column("slid_ratio", &Run::slid_ratio, "", {"across/along", 1.0, 3});
    later_column("deepest", &Run::deepest, "m", {"deepest [mm]", core::millimetres, 2});
    if (runs.empty())
        return;
    columns.blocks("force", &Run::force, num_records, "N");
    columns.blocks("error_over_time", error(&core::ToolErrors::over_time),
                   core::ToolHistory::num_fields(static_cast<int>(num_records)));
}

/// Cells of runs in the order of a key.
template <class Key> hdf5::Cells cells_by(const Arena &arena, Key key) {
    auto runs = arena.runs;
    std::ranges::stable_sort(runs, {}, key);
    hdf5::Cells cells;
    describe_arena_runs(cells, runs, arena.time.size(), Effort::of_budget);
    return cells;
}

template <class At> void describe_arena_methods(At at, Of<At, std::vector<ArenaMethod>> &methods) {
    auto columns = hdf5::columns_of(at, methods);
    columns.texts("names", &ArenaMethod::name);
    columns.texts("sources", &ArenaMethod::source);
    columns.texts("implementations", &ArenaMethod::implementation);
    columns.texts("converge_to", &ArenaMethod::converges_to);
    columns.texts("objections", &ArenaMethod::objection);
}

template <class At> void describe_arena(At root, Of<At, Arena> &arena) {
    hdf5::describe_head(root, arena);
    const auto at = root.group("arena");
    at.number("frame_interval", arena.frame_interval);
    if (at.has("tool")) { // not in files of 0.1.0
        at.text("tool", arena.tool);
        at.number("friction", arena.friction);
        at.number("ball_radius", arena.ball_radius);
        if (at.has("face", arena.face != core::ToolFace::ball)) {
            at.word("face", arena.face);
            at.number("plate_size", arena.plate_size);
        }
    }
    at.text("reference", arena.reference);
    at.number("reference_contact_change", arena.reference_errors.contact);
    at.number("reference_after_change", arena.reference_errors.after);
    at.number("reference_force_change", arena.reference_errors.force);
    at.rows("time", arena.time, "s");
    const auto num_records = arena.time.size();
    at.rows("reference_force", arena.reference_force, "N", num_records);
    if (at.has("reference_pressed_force")) // nor this
        at.number("reference_pressed_force", arena.reference_pressed_force);
    describe_arena_runs(at, arena.runs, num_records, Effort::of_budget);
    if (root.has("series", !arena.series.empty())) // of files since 0.2.0, as the next
        describe_arena_runs(root.group("series"), arena.series, num_records, Effort::given);
    if (root.has("methods", !arena.methods.empty()))
        describe_arena_methods(root.group("methods"), arena.methods);
}

/// NaN last.
double sorted_by(double error) {
    return std::isfinite(error) ? error : std::numeric_limits<double>::infinity();
}

/// Runs of a method on a mesh.
struct MethodRuns {
    int tetrahedra;
    std::string method;
    std::vector<const ArenaRun *> runs{};

    /// The better of the settings within a budget; null if there is none that fits.
    const ArenaRun *best_within(double budget) const {
        const ArenaRun *best = nullptr;
        for (const auto *run : runs)
            if (run->budget == budget && run->outcome == ArenaOutcome::ok &&
                (!best || run->errors.contact < best->errors.contact))
                best = run;
        return best;
    }
    double error_within(double budget) const {
        const auto *best = best_within(budget);
        return best ? best->errors.contact : std::numeric_limits<double>::infinity();
    }
    /// Shortest time of a frame of a run that is chosen; infinity if none is.
    template <class Choose> double least_seconds(const Choose &choose) const {
        double least = std::numeric_limits<double>::infinity();
        for (const auto *run : runs)
            if (choose(*run))
                least = std::min(least, run->frame_seconds);
        return least;
    }
    /// The error within a budget, or why nothing fits.
    std::string cell_within(double budget) const {
        if (const auto *best = best_within(budget))
            return in_percent(best->errors.contact);
        const double least = least_seconds(
            [&](const ArenaRun &run) { return run.budget == budget && run.outcome == ArenaOutcome::too_slow; });
        return std::isfinite(least) ? fmt::format("needs {} ms", in_milliseconds(least)) : "diverged";
    }
    std::string time_of(double error) const {
        const double least = least_seconds([&](const ArenaRun &run) { return run.errors.contact <= error; });
        return std::isfinite(least) ? in_milliseconds(least) : "-";
    }
};

} // namespace

const char *to_string(ArenaOutcome outcome) {
    switch (outcome) {
    case ArenaOutcome::too_slow:
        return "too slow";
    case ArenaOutcome::diverged:
        return "diverged";
    case ArenaOutcome::ok:
        break;
    }
    return "ok";
}

std::string iterations_of(int iterations, int stops_early) {
    return fmt::format("{}{}", stops_early != 0 ? "up to " : "", iterations);
}

void write_arena(const std::filesystem::path &path, const Arena &arena) {
    hdf5::write_record(path, arena, [](auto root, auto &record) { describe_arena(root, record); });
}

Arena read_arena(const std::filesystem::path &path) {
    return hdf5::read_record<Arena>(path, "livermark arena",
                                    [](auto root, auto &record) { describe_arena(root, record); });
}

Layout arena_table(const Arena &arena) {
    return cells_by(arena,
                    [](const ArenaRun &run) {
                        return std::tuple(run.tetrahedra, run.budget, run.outcome, sorted_by(run.errors.contact));
                    })
        .table({"tetrahedra", "budget", "methods", "settings", "steps", "iterations", "contact_error", "force_error",
                "after_error", "volume_error", "smallest_jacobian", "frame_seconds", "frame_seconds_95",
                "worst_frame_seconds", "setup_seconds", "element_passes", "bytes_per_element", "outcomes"});
}

std::string arena_legend() {
    return "iterations: in a step; up to: a limit, of which a method takes fewer because nothing is left to do, so "
           "that the budget is not used up; contact, after: error of the displacement while the tool is in contact, "
           "and after its release; force: error of the force on the tool; volume: largest error of the volume of the "
           "body; least J: smallest ratio of current to initial volume of a tetrahedron; frame, 95 %, worst: processor "
           "time of a frame, median, 95th percentile and largest; passes: passes over all elements in a frame; -: not "
           "known\n";
}

Layout arena_forces(const Arena &arena) {
    return cells_by(arena, [](const ArenaRun &run) { return std::tuple(run.tetrahedra, run.budget); })
        .table({"tetrahedra", "budget", "methods", "settings", "steps", "iterations", "pressed_force", "slid_force",
                "slid_ratio", "deepest", "smallest_jacobian", "frame_seconds", "worst_frame_seconds", "outcomes"});
}

Layout arena_series(const Arena &arena) {
    hdf5::Cells cells;
    describe_arena_runs(cells, arena.series, arena.time.size(), Effort::given);
    hdf5::columns_of(cells, arena.series)
        .column("stiffness",
                [&](const ArenaRun &run) { return run.pressed_force / arena.reference_pressed_force - 1.0; }, "",
                {"stiffness [%]", in_percent});
    return cells.table({"tetrahedra", "methods", "settings", "steps", "iterations", "contact_error", "force_error",
                        "pressed_force", "stiffness", "volume_error", "smallest_jacobian", "frame_seconds",
                        "outcomes"});
}

std::string tool_of(const Arena &arena) {
    if (arena.face != core::ToolFace::ball)
        return fmt::format(
            "the tool is a {} plate of {:.3g} mm from the middle of its face to a side that touches, with "
            "a friction of {:g}",
            to_string(arena.face), 1e3 * arena.plate_size, arena.friction);
    return arena.tool == touching_tool
               ? fmt::format("the tool is a ball of {:.3g} mm that touches, with a friction of {:g}",
                             1e3 * arena.ball_radius, arena.friction)
               : std::string("the tool has hold of its place");
}

std::string calibration_note(const Arena &arena) {
    std::set<std::string> unsteady;
    for (const auto &run : arena.runs)
        if (run.calibration_spread > largest_calibration_spread)
            unsteady.insert(run.method);
    return unsteady.empty()
               ? ""
               : fmt::format("the machine was busy: the times by which steps and iterations of {} were found differ by "
                             "more than {:.0f} %; run them again when nothing else runs\n",
                             fmt::join(unsteady, ", "), 100.0 * largest_calibration_spread);
}

std::string overview_legend() {
    return "ms [%]: error of the displacement in contact within that processor time of a frame; % in [ms]: shortest "
           "time of a frame with that error\n";
}

Layout arena_overview(const Arena &arena) {
    std::set<double> budgets;
    std::vector<MethodRuns> rows;
    for (const auto &run : arena.runs) {
        budgets.insert(run.budget);
        auto row = std::ranges::find_if(
            rows, [&](auto &other) { return other.tetrahedra == run.tetrahedra && other.method == run.method; });
        if (row == rows.end())
            row = rows.insert(row, {run.tetrahedra, run.method});
        row->runs.push_back(&run);
    }
    std::ranges::stable_sort(
        rows, {}, [&](auto &row) { return std::tuple(row.tetrahedra, row.error_within(*budgets.rbegin())); });
    TableOf<MethodRuns> table(std::move(rows));
    table.number("tetrahedra", [](auto &row) { return std::to_string(row.tetrahedra); });
    table.text("method", &MethodRuns::method);
    for (const double budget : budgets)
        table.number(fmt::format("{} ms [%]", in_milliseconds(budget)),
                     [&](auto &row) { return row.cell_within(budget); });
    for (const int part : {20, 10, 5})
        table.number(fmt::format("{} % in [ms]", part), [&](auto &row) { return row.time_of(part / core::percent); });
    return table.layout();
}

} // namespace livermark::results
