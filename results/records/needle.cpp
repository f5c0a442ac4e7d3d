#include "results/records/needle.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include "core/units.hpp"
#include "results/hdf5/record_file.hpp"

namespace livermark::results {

namespace {

using core::millimetres, core::milliseconds, core::percent;

/// A value with what it is off by.
std::string with_error(double value, double reference, int decimals) {
    return fmt::format("{} ({})", fixed(value, decimals),
                       std::isnan(value) ? "-" : fmt::format("{:+.1f}", percent * (value / reference - 1.0)));
}

std::string friction_cell(const FittedNeedle &run) {
    return run.has_friction ? fixed(run.friction, 1) : fmt::format("none below {:.0f}", run.friction);
}

template <class At> void describe_needle_arena_runs(At at, hdf5::Of<At, NeedleArena> &arena) {
    using Run = NeedleArenaRun;
    const auto num_records = arena.depth.size();
    auto columns = hdf5::columns_of(at, arena.runs);
    const auto force_column = [&](const char *name, double NeedleForces::*force, const std::string &units,
                                  int decimals) {
        columns.column(name, hdf5::inside(&Run::forces, force), units,
                       {fmt::format("{} [{}] (%)", name, units), [&, force, decimals](double value) {
                            return with_error(value, arena.reference_forces.*force, decimals);
                        }});
    };
    columns.texts("methods", &Run::method, "method");
    columns.texts("settings", &Run::setting, "setting");
    columns.words("outcomes", &Run::outcome, "outcome");
    columns.column("tetrahedra", &Run::tetrahedra, "", "tetrahedra");
    columns.column("budget", &Run::budget, "s", {"budget [ms]", milliseconds, 2});
    columns.column("steps", &Run::steps, "", "steps");
    columns.column("iterations", &Run::iterations, "",
                   {"iterations", [](const Run &run) { return iterations_of(run.iterations, run.stops_early); }});
    columns.blocks("force", &Run::force, num_records, "N");
    columns.blocks("tip", &Run::tip, num_records, "m");
    columns.blocks("target", &Run::target, num_records, "m");
    columns.column("target_error", &Run::target_error, "m", {"target off [mm]", millimetres, 2});
    columns.column("path_error", &Run::path_error, "", {"path [%]", percent, 1});
    force_column("peak", &NeedleForces::peak, "N", 3);
    force_column("slope", &NeedleForces::slope, "N/m", 1);
    force_column("pull", &NeedleForces::pull, "N", 3);
    columns.column("frame_seconds", &Run::frame_seconds, "s", {"frame [ms]", milliseconds, 2});
    columns.column("frame_seconds_95", &Run::frame_seconds_95, "s");
    columns.column("worst_frame_seconds", &Run::worst_frame_seconds, "s", {"worst [ms]", milliseconds, 2});
    columns.column("cost_ratio", &Run::cost_ratio, "", {"needle/none", 1.0, 2});
    columns.column("setup_seconds", &Run::setup_seconds, "s");
    columns.column("calibration_spread", &Run::calibration_spread);
    if (at.has("stops_early")) // not in files of an older version
        columns.column("stops_early", &Run::stops_early);
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
        describe_needle_arena_runs(at.group("runs"), arena);
}

/// Datasets with a row for each record.
template <class At> void describe_insertion(At at, hdf5::Of<At, core::Insertion> &insertion) {
    at.rows("depth", insertion.depth, "m");
    const auto num_records = insertion.depth.size();
    at.rows("force", insertion.force, "N", num_records);
    at.rows("tip", insertion.tip, "m", num_records);
    at.rows("target", insertion.target, "m", num_records);
    at.rows("entry", insertion.entry, "m", num_records);
    at.rows("work", insertion.work, "J", num_records);
    at.rows("stored", insertion.stored, "J", num_records);
    at.rows("friction", insertion.friction, "J", num_records);
    at.rows("tearing", insertion.tearing, "J", num_records);
    if (at.has("holding")) // not in files of an older version
        at.rows("holding", insertion.holding, "J", num_records);
    at.integer("at_plan", insertion.at_plan, 0, insertion.num_records() - 1);
    at.number("puncture_depth", insertion.puncture_depth);
    at.number("puncture_loss", insertion.puncture_loss);
    if (at.has("stopped_at")) // nor this
        at.number("stopped_at", insertion.stopped_at);
}

template <class At> void describe_needle(At at, hdf5::Of<At, NeedleStudy> &study) {
    auto &needle = study.needle;
    at.text("name", needle.name);
    at.rows_of("way", "m", needle.entry, needle.target);
    at.number("diameter", needle.diameter);
    at.number("spread", needle.spread);
    at.number("toughness", needle.toughness);
    at.number("friction", needle.friction);
    at.number("puncture_force", needle.puncture_force);
    at.number("step", needle.step);
    if (at.has("side_stiffness")) // not in files of an older version
        at.number("side_stiffness", needle.side_stiffness);
    std::string reference = study.runs.empty() ? "" : study.runs.front().model;
    at.text("reference", reference);
    at.number("reference_miss_change", study.reference_miss_change);
    at.number("reference_force_change", study.reference_force_change);
    at.group("models", hdf5::Order::kept).each(study.runs, &NeedleRun::model, [](auto group, auto &run) {
        describe_insertion(group, run.insertion);
        group.number("setup_seconds", run.setup_seconds);
        if (group.has("solve_seconds")) // not in files of an older version
            group.number("solve_seconds", run.solve_seconds);
        if (group.has("left_regime_at")) // nor this
            group.number("left_regime_at", run.left_regime_at);
    });
    at.check(!study.runs.empty() && study.runs.front().model == reference, "does not begin with its reference");
    for (const auto &run : study.runs)
        at.check(run.insertion.at_plan == study.runs.front().insertion.at_plan, "has models with different steps");
    at.optional("arena", study.arena, [&](auto &arena) { describe_needle_arena(at.group("arena"), arena); });
}

template <class At> void describe_needles(At root, hdf5::Of<At, NeedleFile> &file) {
    hdf5::describe_head(root, file);
    if (root.has("regime")) // not in files of an older version
        root.word("regime", file.regime);
    root.group("needles", hdf5::Order::kept)
        .each(
            file.needles, [](auto at, auto &study) { describe_needle(at, study); }, hdf5::Order::kept);
    root.check(!file.needles.empty(), "needles", "is empty");
}

/// Part of the work of the hand: what balances, balances to 2 %.
constexpr double most_energy_error = 0.05;

std::string or_unknown(double value, double factor, int decimals, const char *units) {
    return std::isnan(value) ? "an amount that is not known"
                             : fmt::format("{} {}", fixed(factor * value, decimals), units);
}

} // namespace

NeedleForces needle_forces(const std::vector<double> &depth, const std::vector<double> &force, int at_plan) {
    NeedleForces found;
    found.peak = *std::max_element(force.begin(), force.begin() + at_plan + 1);
    found.pull = std::max(0.0, -*std::min_element(force.begin() + at_plan, force.end()));
    const int from = at_plan / 2, count = at_plan + 1 - from;
    double mean_depth = 0.0, mean_force = 0.0;
    for (int j = from; j <= at_plan; ++j) {
        mean_depth += depth[j] / count;
        mean_force += force[j] / count;
    }
    double together = 0.0, square = 0.0;
    for (int j = from; j <= at_plan; ++j) {
        together += (depth[j] - mean_depth) * (force[j] - mean_force);
        square += (depth[j] - mean_depth) * (depth[j] - mean_depth);
    }
    found.slope = together / square;
    return found;
}

double NeedleRun::largest_force(const core::Needle &needle) const {
    // Until the surface gives way nothing of the shaft is inside: the hand bears what the tip exerts. NaN if it holds.
    double largest = insertion.puncture_depth <= insertion.depth[insertion.at_plan] ? needle.puncture_force : 0.0;
    for (int j = 0; j <= insertion.at_plan; ++j)
        largest = std::max(largest, insertion.force[j]);
    return largest;
}

void NeedleRun::note_limit(double largest_small) {
    for (int j = 0; j <= insertion.at_plan && std::isnan(left_regime_at); ++j)
        if (insertion.moved[j] > largest_small)
            left_regime_at = insertion.depth[j];
}

double NeedleRun::largest_pull() const {
    if (std::isnan(force_at_plan()))
        return force_at_plan();
    return std::max(0.0, -*std::min_element(insertion.force.begin() + insertion.at_plan, insertion.force.end()));
}

double NeedleRun::energy_error() const {
    const auto at_plan = static_cast<std::size_t>(insertion.at_plan);
    double largest = 0.0;
    for (std::size_t j = 0; j < insertion.work.size(); ++j) {
        const bool is_punctured = insertion.depth[j] >= insertion.puncture_depth || j >= at_plan;
        largest = std::max(largest, std::abs(insertion.work[j] - insertion.stored[j] - insertion.friction[j] -
                                             insertion.tearing[j] - insertion.holding[j] -
                                             (is_punctured ? insertion.puncture_loss : 0.0)));
    }
    return largest / insertion.work[at_plan];
}

double force_error(const core::Insertion &insertion, const core::Insertion &reference) {
    double difference = 0.0, size = 0.0;
    for (int j = 0; j <= reference.at_plan; ++j) {
        difference += std::pow(insertion.force[j] - reference.force[j], 2);
        size += std::pow(reference.force[j], 2);
    }
    return std::sqrt(difference / size);
}

void write_needles(const std::filesystem::path &path, const NeedleFile &needles) {
    hdf5::write_record(path, needles, [](auto root, auto &record) { describe_needles(root, record); });
}

NeedleFile read_needles_file(const std::filesystem::path &path) {
    return hdf5::read_record<NeedleFile>(path, "livermark needle",
                                         [](auto root, auto &record) { describe_needles(root, record); });
}

Layout needle_table(const NeedleFile &file) {
    struct Row {
        const NeedleStudy &study;
        const NeedleRun &run, &reference;
        bool judges() const { return &run == &reference; }
    };
    std::vector<Row> rows;
    for (const auto &study : file.needles)
        for (const auto &run : study.runs)
            rows.push_back({study, run, study.runs.front()});
    TableOf<Row> table(std::move(rows));
    table.text("needle", [](auto &row) { return row.study.needle.name; });
    table.text("model", [](auto &row) { return row.run.model + (row.judges() ? " (reference)" : ""); });
    table.number("target moved [mm]", [](auto &row) { return fixed(millimetres * row.run.miss().norm(), 2); });
    table.number("off by [mm]", [](auto &row) {
        return row.judges() ? "-" : fixed(millimetres * (row.run.miss() - row.reference.miss()).norm(), 2);
    });
    table.number("short of it [mm]",
                 [](auto &row) { return fixed(millimetres * row.run.short_of_target(row.study.needle), 2); });
    table.number("force there [N]", [](auto &row) { return fixed(row.run.force_at_plan(), 3); });
    table.number("largest [N]", [](auto &row) { return fixed(row.run.largest_force(row.study.needle), 3); });
    table.number("punctured at [mm]",
                 [](auto &row) { return fixed(millimetres * row.run.insertion.puncture_depth, 1); });
    table.number("pull out [N]", [](auto &row) { return fixed(row.run.largest_pull(), 3); });
    table.number("force off by [%]", [](auto &row) {
        return row.judges() ? "-" : fixed(percent * force_error(row.run.insertion, row.reference.insertion), 1);
    });
    return table.layout();
}

std::string limit_note(const NeedleStudy &study) {
    std::map<double, std::vector<std::string>> models; // by depth
    for (const auto &run : study.runs)
        if (!std::isnan(run.left_regime_at))
            models[run.left_regime_at].push_back(run.model);
    if (models.empty())
        return "";
    std::vector<std::string> depths;
    for (const auto &[depth, names] : models)
        depths.push_back(fmt::format("{:.1f} mm ({})", millimetres * depth, fmt::join(names, ", ")));
    return fmt::format(
        "{}: small regime left at {}: from there on tissue moves further than small deformations go, and "
        "the numbers say nothing of it; use --regime large\n",
        printable(study.needle.name), fmt::join(depths, ", "));
}

std::string needle_note(const NeedleFile &file) {
    std::string note;
    for (const auto &study : file.needles) {
        note += limit_note(study);
        for (const auto &run : study.runs) {
            if (run.energy_error() > most_energy_error)
                note +=
                    fmt::format("{}: energies of {} miss {:.0f} % of the work of the hand, as where springs fold; do "
                                "not rely on it here\n",
                                printable(study.needle.name), run.model, percent * run.energy_error());
            if (!std::isnan(run.insertion.stopped_at))
                note += fmt::format("{}: {} finds no equilibrium with the tip at a depth of {:.1f} mm, on the way {}; "
                                    "take a smaller force of the puncture or a finer mesh\n",
                                    printable(study.needle.name), run.model, millimetres * run.insertion.stopped_at,
                                    std::isnan(run.force_at_plan()) ? "in" : "out");
        }
        if (std::isnan(study.reference_miss_change)) {
            note += fmt::format("{}: {} is on the mesh itself, and how far it is from finer ones is not known\n",
                                printable(study.needle.name), study.runs.front().model);
            continue;
        }
        note += fmt::format("{}: the last refinement of {} near the needle moved the target by {:.3f} mm and changed "
                            "the force by {:.2f} %\n",
                            printable(study.needle.name), study.runs.front().model,
                            millimetres * study.reference_miss_change, percent * study.reference_force_change);
    }
    return note;
}

Layout measured_needle_table(const MeasuredNeedle &measured) {
    std::vector<std::size_t> stretches(measured.from.size());
    std::iota(stretches.begin(), stretches.end(), 0);
    const auto force = [](const std::vector<double> &values) { return [&values](std::size_t b) { return values[b]; }; };
    TableOf<std::size_t> table(std::move(stretches));
    table.number("depth [mm]", [&](std::size_t b) {
        const int decimals = measured.to[b] - measured.from[b] < 0.001 ? 2 : 0;
        return fmt::format("{:.{}f} to {:.{}f}", millimetres * measured.from[b], decimals, millimetres * measured.to[b],
                           decimals);
    });
    table.number("measured [N]", force(measured.mean), 1.0, 2);
    table.number("lowest", force(measured.lowest), 1.0, 2);
    table.number("highest", force(measured.highest), 1.0, 2);
    for (const auto &run : measured.runs)
        table.number(run.model, force(run.force), 1.0, 2);
    return table.layout();
}

Layout fitted_needle_table(const MeasuredNeedle &measured) {
    /// Cells of the models, and one of the measurement.
    const auto cells = [](auto cell, const std::string &measurement = "") {
        return [=](const FittedNeedle *run) { return run ? cell(*run) : measurement; };
    };
    std::vector<const FittedNeedle *> rows;
    for (const auto &run : measured.runs)
        rows.push_back(&run);
    rows.push_back(nullptr);
    TableOf<const FittedNeedle *> table(std::move(rows));
    const auto work = [](double value) { return fixed(core::millijoules * value, 1); };
    table.text("model", cells([](auto &run) { return run.model; }, "measured"));
    table.number("stiffness, fitted", cells([](auto &run) { return fmt::format("x {:.2f}", run.stiffness); }));
    table.number("friction, fitted [N/m]", cells([](auto &run) { return friction_cell(run); }));
    table.number("off before the puncture [N]", cells([](auto &run) { return fixed(run.error_before, 2); }));
    table.number("off behind it [N]", cells([](auto &run) { return fixed(run.error, 2); }));
    table.number("work [mJ]", cells([&](const auto &run) { return work(run.work); }, work(measured.work)));
    if (!std::isnan(measured.pull))
        table.number("pull out [N]", cells([](auto &run) { return fixed(run.pull, 2); }, fixed(measured.pull, 2)));
    return table.layout();
}

Layout needle_records_table(std::span<const MeasuredNeedle> records) {
    std::vector<const MeasuredNeedle *> rows;
    for (const auto &record : records)
        rows.push_back(&record);
    TableOf<const MeasuredNeedle *> table(std::move(rows));
    table.text("record", [](auto *record) { return record->name; });
    table.number("touched at [mm]", [](auto *record) { return fixed(millimetres * record->touched_at, 1); });
    table.number("punctured at [mm]", [](auto *record) { return fixed(millimetres * record->puncture_depth, 1); });
    table.number("force there [N]", [](auto *record) { return fixed(record->needle.puncture_force, 2); });
    table.number("lowest behind it [N]", [](auto *record) { return fixed(record->lowest_behind, 2); });
    table.number("slope behind it [N/m]", [](auto *record) { return fixed(record->slope, 1); });
    table.number("friction, " + records.front().runs.front().model + " [N/m]",
                 [](auto *record) { return friction_cell(record->runs.front()); });
    table.number("held for [s]", [](auto *record) { return fixed(record->held_for, 1); });
    table.number("force then, from [N]", [](auto *record) { return fixed(record->held_from, 2); });
    table.number("to [N]", [](auto *record) { return fixed(record->held_to, 2); });
    table.number("pull out [N]", [](auto *record) { return fixed(record->pull, 2); });
    return table.layout();
}

Layout needle_arena_table(const NeedleArena &arena) {
    auto sorted = arena;
    std::ranges::stable_sort(sorted.runs, {}, [](const NeedleArenaRun &run) {
        return std::tuple(run.tetrahedra, run.budget,
                          std::isfinite(run.target_error) ? run.target_error : std::numeric_limits<double>::infinity());
    });
    hdf5::Cells cells;
    describe_needle_arena_runs(cells, sorted);
    return cells.table({"tetrahedra", "budget", "methods", "settings", "steps", "iterations", "target_error",
                        "path_error", "peak", "slope", "pull", "frame_seconds", "worst_frame_seconds", "cost_ratio",
                        "outcomes"});
}

std::string needle_arena_note(const NeedleStudy &study) {
    const auto &arena = *study.arena;
    const auto &reference = study.runs.front();
    const auto at_plan = static_cast<std::size_t>(arena.at_plan);
    std::string note = fmt::format(
        "{}: {:.1f} mm in at {:g} mm/s, {:g} s of rest and out; the reference is the static {}, whose target has moved "
        "by {} mm when the tip is where it was at rest (last refinement: {}), with a peak of {} N ({}), a slope of {} "
        "N/m ({}) and a pull of {} N ({})\n",
        printable(study.needle.name), millimetres * study.needle.depth(), millimetres * arena.speed, arena.rest,
        reference.model, fixed(millimetres * arena.reference_target[at_plan].norm(), 2),
        or_unknown(study.reference_miss_change, millimetres, 3, "mm"), fixed(arena.reference_forces.peak, 3),
        or_unknown(arena.reference_changes.peak, 1.0, 4, "N"), fixed(arena.reference_forces.slope, 1),
        or_unknown(arena.reference_changes.slope, 1.0, 2, "N/m"), fixed(arena.reference_forces.pull, 3),
        or_unknown(arena.reference_changes.pull, 1.0, 4, "N"));
    std::map<std::string, std::vector<std::string>> by_reason;
    for (const auto &[method, because] : arena.left_out)
        by_reason[because].push_back(method);
    for (const auto &[because, methods] : by_reason)
        note += fmt::format("left out: {}, because {}\n", fmt::join(methods, ", "), because);
    return note + limit_note(study);
}

} // namespace livermark::results
