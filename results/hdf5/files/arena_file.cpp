#include "results/hdf5/files/arena_file.hpp"

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/outcome_words.hpp"

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

} // namespace

void write_arena(const std::filesystem::path &path, const Arena &arena) {
    hdf5::write_record(path, arena, [](auto root, auto &record) { describe_arena(root, record); });
}

Arena read_arena(const std::filesystem::path &path) {
    return hdf5::read_record<Arena>(path, "livermark arena",
                                    [](auto root, auto &record) { describe_arena(root, record); });
}

} // namespace livermark::results
