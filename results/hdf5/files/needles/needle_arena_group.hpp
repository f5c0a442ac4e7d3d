#pragma once

#include "results/hdf5/io/columns.hpp"
#include "results/hdf5/io/described.hpp"
#include "results/hdf5/outcome_words.hpp"
#include "results/records/needle_arena.hpp"

/// What results/schema.md says of /needles/<n>/arena.
namespace livermark::results {

/// @param num_records  K
template <class At>
void describe_needle_arena_runs(At at, hdf5::Of<At, std::vector<NeedleArenaRun>> &runs, std::size_t num_records) {
    auto columns = hdf5::columns_of(at, runs);
    columns.texts("methods", &NeedleArenaRun::method);
    columns.texts("settings", &NeedleArenaRun::setting);
    columns.words("outcomes", &NeedleArenaRun::outcome);
    columns.column("tetrahedra", &NeedleArenaRun::tetrahedra);
    columns.column("budget", &NeedleArenaRun::budget, "s");
    columns.column("steps", &NeedleArenaRun::steps);
    columns.column("iterations", &NeedleArenaRun::iterations);
    columns.blocks("force", &NeedleArenaRun::force, num_records, "N");
    columns.blocks("tip", &NeedleArenaRun::tip, num_records, "m");
    columns.blocks("target", &NeedleArenaRun::target, num_records, "m");
    columns.column("target_error", &NeedleArenaRun::target_error, "m");
    columns.column("path_error", &NeedleArenaRun::path_error);
    columns.column(
        "peak", [](auto &run) -> auto & { return run.forces.peak; }, "N");
    columns.column(
        "slope", [](auto &run) -> auto & { return run.forces.slope; }, "N/m");
    columns.column(
        "pull", [](auto &run) -> auto & { return run.forces.pull; }, "N");
    columns.column("frame_seconds", &NeedleArenaRun::frame_seconds, "s");
    columns.column("frame_seconds_95", &NeedleArenaRun::frame_seconds_95, "s");
    columns.column("worst_frame_seconds", &NeedleArenaRun::worst_frame_seconds, "s");
    columns.column("cost_ratio", &NeedleArenaRun::cost_ratio);
    columns.column("setup_seconds", &NeedleArenaRun::setup_seconds, "s");
    columns.column("calibration_spread", &NeedleArenaRun::calibration_spread);
    if (at.has("stops_early")) // not in files of an older version
        columns.column("stops_early", &NeedleArenaRun::stops_early);
}

template <class At> void describe_needle_arena(At at, hdf5::Of<At, NeedleArena> &arena) {
    at.number("speed", arena.speed);
    at.number("rest", arena.rest);
    at.number("mass_damping", arena.mass_damping);
    at.number("frame_interval", arena.frame_interval);
    at.number("reference_peak", arena.reference_forces.peak);
    at.number("reference_slope", arena.reference_forces.slope);
    at.number("reference_pull", arena.reference_forces.pull);
    at.number("reference_peak_change", arena.reference_changes.peak);
    at.number("reference_slope_change", arena.reference_changes.slope);
    at.number("reference_pull_change", arena.reference_changes.pull);
    at.rows("depth", arena.depth, "m");
    const auto num_records = arena.depth.size();
    at.integer("at_plan", arena.at_plan, 0, static_cast<std::int64_t>(num_records) - 1);
    at.rows("reference_force", arena.reference_force, "N", num_records);
    at.rows("reference_target", arena.reference_target, "m", num_records);
    auto left_out = hdf5::columns_of(at, arena.left_out);
    left_out.texts("left_out", &LeftOut::method);
    left_out.texts("left_out_because", &LeftOut::because);
    if (at.has("runs", !arena.runs.empty()))
        describe_needle_arena_runs(at.group("runs"), arena.runs, num_records);
}

} // namespace livermark::results
