#include "results/records/arena.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/described.hpp"

namespace livermark::results {

namespace {

using hdf5::Of;

/// Runs with given iterations have no budget, so nothing was measured to keep
/// to it.
enum class Effort { of_budget, given };

/// @param num_records  K
template <class At>
void describe_arena_runs(At at, Of<At, std::vector<ArenaRun>> &runs, std::size_t num_records, Effort effort) {
    auto columns = hdf5::columns_of(at, runs);
    const auto later_column = [&](const char *name, auto value, const char *units) {
        if (at.has(name)) // not in files of 0.1.0
            columns.column(name, value, units);
    };
    columns.texts("methods", &ArenaRun::method);
    columns.texts("settings", &ArenaRun::setting);
    columns.words("outcomes", &ArenaRun::outcome);
    columns.column("tetrahedra", &ArenaRun::tetrahedra);
    if (effort == Effort::of_budget)
        columns.column("budget", &ArenaRun::budget, "s");
    columns.column("steps", &ArenaRun::steps);
    columns.column("iterations", &ArenaRun::iterations);
    columns.column(
        "contact_error", [](auto &run) -> auto & { return run.errors.contact; });
    columns.column(
        "after_error", [](auto &run) -> auto & { return run.errors.after; });
    columns.column(
        "force_error", [](auto &run) -> auto & { return run.errors.force; });
    columns.column("volume_error", &ArenaRun::volume_error);
    columns.column("smallest_jacobian", &ArenaRun::smallest_jacobian);
    columns.column("num_inverted", &ArenaRun::num_inverted);
    columns.column("frame_seconds", &ArenaRun::frame_seconds, "s");
    columns.column("frame_seconds_95", &ArenaRun::frame_seconds_95, "s");
    columns.column("worst_frame_seconds", &ArenaRun::worst_frame_seconds, "s");
    columns.column("setup_seconds", &ArenaRun::setup_seconds, "s");
    columns.column("release_seconds", &ArenaRun::release_seconds, "s");
    columns.column("element_passes", &ArenaRun::element_passes);
    columns.column("bytes_per_element", &ArenaRun::bytes_per_element);
    if (effort == Effort::of_budget) {
        later_column("calibration_spread", &ArenaRun::calibration_spread, "");
        later_column("stops_early", &ArenaRun::stops_early, "");
    }
    later_column("pressed_force", &ArenaRun::pressed_force, "N");
    later_column("slid_force", &ArenaRun::slid_force, "N");
    later_column("slid_ratio", &ArenaRun::slid_ratio, "");
    later_column("deepest", &ArenaRun::deepest, "m");
    if (runs.empty())
        return;
    columns.blocks("force", &ArenaRun::force, num_records, "N");
    columns.blocks(
        "error_over_time", [](auto &run) -> auto & { return run.errors.over_time; },
        core::ToolHistory::num_fields(static_cast<int>(num_records)));
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
    root.text("body", arena.body);
    root.text("load_case", arena.load_case);
    root.text("title", arena.title);
    const auto at = root.group("arena");
    at.number("frame_interval", arena.frame_interval);
    if (at.has("tool")) { // not in files of 0.1.0
        at.text("tool", arena.tool);
        at.number("friction", arena.friction);
        at.number("ball_radius", arena.ball_radius);
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
    if (root.has("series",
                 !arena.series.empty())) // of files since 0.2.0, as the next
        describe_arena_runs(root.group("series"), arena.series, num_records, Effort::given);
    if (root.has("methods", !arena.methods.empty()))
        describe_arena_methods(root.group("methods"), arena.methods);
}

std::string in_percent(double value) {
    return std::isfinite(value) ? fixed(100.0 * value, 1) : "-";
}

std::string in_milliseconds(double seconds) {
    return fixed(1e3 * seconds, seconds < 0.1 ? 2 : 0); // "-" where somebody else does not say it
}

/// "-" where somebody else does not say it.
std::string count_or_dash(double count) {
    return fixed(count > 0.0 ? count : std::numeric_limits<double>::quiet_NaN(), 0);
}

/// NaN last.
double sorted_by(double error) {
    return std::isfinite(error) ? error : std::numeric_limits<double>::infinity();
}

/// The better of the settings within a budget; null if there is none that fits.
const ArenaRun *best_within(const std::vector<const ArenaRun *> &runs, double budget) {
    const ArenaRun *best = nullptr;
    for (const auto *run : runs)
        if (run->budget == budget && run->outcome == ArenaOutcome::ok &&
            (!best || run->errors.contact < best->errors.contact))
            best = run;
    return best;
}

std::string least_seconds(const std::vector<const ArenaRun *> &runs, double error) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto *run : runs)
        if (run->errors.contact <= error)
            least = std::min(least, run->frame_seconds);
    return std::isfinite(least) ? in_milliseconds(least) : "-";
}

/// Why nothing fits.
std::string why_not(const std::vector<const ArenaRun *> &runs, double budget) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto *run : runs)
        if (run->budget == budget && run->outcome == ArenaOutcome::too_slow)
            least = std::min(least, run->frame_seconds);
    return std::isfinite(least) ? fmt::format("needs {} ms", in_milliseconds(least)) : "diverged";
}

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
    Layout layout{{{"tetrahedra", true},
                   {"budget [ms]", true},
                   {"method"},
                   {"setting"},
                   {"steps", true},
                   {"iterations", true},
                   {"contact [%]", true},
                   {"force [%]", true},
                   {"after [%]", true},
                   {"volume [%]", true},
                   {"least J", true},
                   {"frame [ms]", true},
                   {"95 % [ms]", true},
                   {"worst [ms]", true},
                   {"setup [s]", true},
                   {"passes", true},
                   {"B/tetrahedron", true},
                   {"outcome"}},
                  {}};
    std::vector<const ArenaRun *> runs;
    for (const auto &run : arena.runs)
        runs.push_back(&run);
    std::ranges::stable_sort(runs, {}, [](const ArenaRun *run) {
        return std::tuple(run->tetrahedra, run->budget, run->outcome, sorted_by(run->errors.contact));
    });
    for (const auto *run : runs)
        layout.rows.push_back(
            {fmt::format("{}", run->tetrahedra), in_milliseconds(run->budget), run->method, run->setting,
             count_or_dash(run->steps), run->iterations > 0 ? iterations_of(run->iterations, run->stops_early) : "-",
             in_percent(run->errors.contact), in_percent(run->errors.force), in_percent(run->errors.after),
             fixed(100.0 * run->volume_error, 2), fixed(run->smallest_jacobian, 2), in_milliseconds(run->frame_seconds),
             in_milliseconds(run->frame_seconds_95), in_milliseconds(run->worst_frame_seconds),
             fixed(run->setup_seconds, 2), (run->stops_early != 0 ? "up to " : "") + count_or_dash(run->element_passes),
             count_or_dash(run->bytes_per_element), to_string(run->outcome)});
    return layout;
}

std::string arena_legend() {
    return "iterations: in a step; up to: a limit, of which a method takes fewer because nothing is left to do, so "
           "that "
           "the budget is not used up; contact, after: error of the displacement while the tool is in contact, and "
           "after its release; force: "
           "error "
           "of the force on the tool; volume: largest error of the volume of the body; least J: smallest ratio of "
           "current to initial volume of a tetrahedron; frame, 95 %, worst: processor time of a frame, median, 95th "
           "percentile and largest; passes: passes over all elements in a frame; -: not known\n";
}

Layout arena_forces(const Arena &arena) {
    Layout layout{{{"tetrahedra", true},
                   {"budget [ms]", true},
                   {"method"},
                   {"setting"},
                   {"steps", true},
                   {"iterations", true},
                   {"pressed [N]", true},
                   {"sliding [N]", true},
                   {"across/along", true},
                   {"deepest [mm]", true},
                   {"least J", true},
                   {"frame [ms]", true},
                   {"worst [ms]", true},
                   {"outcome"}},
                  {}};
    std::vector<const ArenaRun *> runs;
    for (const auto &run : arena.runs)
        runs.push_back(&run);
    std::ranges::stable_sort(runs, {}, [](const ArenaRun *run) { return std::tuple(run->tetrahedra, run->budget); });
    for (const auto *run : runs)
        layout.rows.push_back({fmt::format("{}", run->tetrahedra), in_milliseconds(run->budget), run->method,
                               run->setting, fmt::format("{}", run->steps),
                               iterations_of(run->iterations, run->stops_early), fixed(run->pressed_force, 3),
                               fixed(run->slid_force, 3), fixed(run->slid_ratio, 3), fixed(1e3 * run->deepest, 2),
                               fixed(run->smallest_jacobian, 2), in_milliseconds(run->frame_seconds),
                               in_milliseconds(run->worst_frame_seconds), to_string(run->outcome)});
    return layout;
}

Layout arena_series(const Arena &arena) {
    Layout layout{{{"tetrahedra", true},
                   {"method"},
                   {"setting"},
                   {"steps", true},
                   {"iterations", true},
                   {"contact [%]", true},
                   {"force [%]", true},
                   {"pressed [N]", true},
                   {"stiffness [%]", true},
                   {"volume [%]", true},
                   {"least J", true},
                   {"frame [ms]", true},
                   {"outcome"}},
                  {}};
    for (const auto &run : arena.series)
        layout.rows.push_back({fmt::format("{}", run.tetrahedra), run.method, run.setting, fmt::format("{}", run.steps),
                               fmt::format("{}", run.iterations), in_percent(run.errors.contact),
                               in_percent(run.errors.force), fixed(run.pressed_force, 3),
                               in_percent(run.pressed_force / arena.reference_pressed_force - 1.0),
                               fixed(100.0 * run.volume_error, 2), fixed(run.smallest_jacobian, 2),
                               in_milliseconds(run.frame_seconds), to_string(run.outcome)});
    return layout;
}

std::string tool_of(const Arena &arena) {
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
           "time "
           "of a frame with that error\n";
}

Layout arena_overview(const Arena &arena) {
    std::set<double> budgets;
    std::map<int, std::vector<std::string>> methods; // of each mesh, as they come
    std::map<std::pair<int, std::string>, std::vector<const ArenaRun *>> runs;
    for (const auto &run : arena.runs) {
        budgets.insert(run.budget);
        auto &of_method = runs[{run.tetrahedra, run.method}];
        if (of_method.empty())
            methods[run.tetrahedra].push_back(run.method);
        of_method.push_back(&run);
    }
    Layout layout{{{"tetrahedra", true}, {"method"}}, {}};
    for (const double budget : budgets)
        layout.columns.push_back({fmt::format("{} ms [%]", in_milliseconds(budget)), true});
    for (const int part : {20, 10, 5})
        layout.columns.push_back({fmt::format("{} % in [ms]", part), true});
    for (auto &of_mesh : methods) {
        const int tetrahedra = of_mesh.first;
        auto &names = of_mesh.second;
        std::ranges::stable_sort(names, {}, [&](const std::string &name) {
            const auto *best = best_within(runs[{tetrahedra, name}], *budgets.rbegin());
            return best ? best->errors.contact : std::numeric_limits<double>::infinity();
        });
        for (const auto &name : names) {
            const auto &of_method = runs[{tetrahedra, name}];
            std::vector<std::string> row{fmt::format("{}", tetrahedra), name};
            for (const double budget : budgets) {
                const auto *best = best_within(of_method, budget);
                row.push_back(best ? in_percent(best->errors.contact) : why_not(of_method, budget));
            }
            for (const double error : {0.2, 0.1, 0.05})
                row.push_back(least_seconds(of_method, error));
            layout.rows.push_back(std::move(row));
        }
    }
    return layout;
}

} // namespace livermark::results
