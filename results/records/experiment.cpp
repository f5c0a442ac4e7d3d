#include "results/records/experiment.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <map>

#include "core/units.hpp"
#include "results/hdf5/record_file.hpp"

namespace livermark::results {

namespace {

std::string with_decimals(double value, int decimals) {
    return std::isfinite(value) ? fixed(value, decimals) : "-";
}

/// A length that is 0 where it is not known.
std::string in_mm_if_known(double length) {
    return length > 0.0 ? length_cell(length) : "-";
}

using hdf5::Of;

template <class At> void describe_markers(At at, Of<At, ExperimentResult> &result) {
    at.texts("names", result.markers);
    at.texts("drives", result.drives, result.markers.size());
    at.rows("position", result.positions, "m", result.markers.size());
}

template <class At> void describe_states(At at, Of<At, std::vector<ExperimentState>> &states, std::size_t num_markers) {
    auto columns = hdf5::columns_of(at, states);
    columns.texts("names", &ExperimentState::name);
    const auto length = [&](const char *name, double ExperimentState::*value, const char *title, int decimals = 2) {
        columns.column(name, value, "m", {title, [decimals](double error) { return length_cell(error, decimals); }});
    };
    columns.column("noise", &ExperimentState::noise, "m", {"noise of the measurement", in_mm_if_known});
    length("no_motion", &ExperimentState::no_motion, "no motion");
    length("rigid_motion", &ExperimentState::rigid_motion, "rigid motion, fitted");
    length("affine_map", &ExperimentState::affine_map, "affine map, fitted");
    length("straight_line", &ExperimentState::straight_line, "straight line");
    length("fit_residual", &ExperimentState::fit_residual, "driven places off their markers");
    length("reference_uncertainty", &ExperimentState::reference_uncertainty, "reference, uncertainty of its mesh", 3);
    if (num_markers > 0)
        columns.blocks("displacement", &ExperimentState::displacement, num_markers, "m");
}

template <class At>
void describe_runs(At at, Of<At, std::vector<ExperimentRun>> &runs, std::size_t num_states, std::size_t num_markers) {
    auto columns = hdf5::columns_of(at, runs);
    columns.texts("models", &ExperimentRun::model);
    columns.words("statuses", &ExperimentRun::status);
    columns.texts("messages", &ExperimentRun::message);
    columns.column("state", &ExperimentRun::state);
    for (const auto &run : runs)
        at.check(run.state >= 0 && static_cast<std::size_t>(run.state) < num_states, "state",
                 "has a state that is not there");
    columns.column("tetrahedra", &ExperimentRun::tetrahedra);
    columns.column("error", &ExperimentRun::error, "m");
    columns.column("worst_error", &ExperimentRun::worst_error, "m");
    if (at.has("component_error")) { // files of older versions have none
        columns.blocks("component_error", &ExperimentRun::component_error, 3, "m");
        columns.blocks("beyond_reference", &ExperimentRun::beyond_reference, 3, "m");
    }
    columns.column("seconds", &ExperimentRun::seconds, "s");
    if (num_markers > 0)
        columns.blocks("displacement", &ExperimentRun::displacement, num_markers, "m");
}

/// The body, and how the refined reference deforms it in each state.
template <class At> void describe_deformed_body(At at, Of<At, ExperimentResult> &result) {
    at.rows("points", result.points, "m");
    at.node_numbers("boundary_triangles", result.boundary, result.points.size());
    hdf5::columns_of(at, result.states, result.states.size())
        .blocks("displacement", &ExperimentState::deformed, result.points.size(), "m");
}

/// @param num_vectors  of the displacement: records times markers
template <class At> void describe_ringing_runs(At at, Of<At, std::vector<RingDownRun>> &runs, std::size_t num_vectors) {
    auto columns = hdf5::columns_of(at, runs);
    columns.texts("models", &RingDownRun::model);
    columns.words("statuses", &RingDownRun::status);
    columns.texts("messages", &RingDownRun::message);
    columns.texts("integrators", &RingDownRun::integrator);
    columns.column("tetrahedra", &RingDownRun::tetrahedra);
    columns.column("time_step", &RingDownRun::time_step, "s");
    columns.column("alpha", hdf5::inside(&RingDownRun::damping, &core::RayleighDamping::alpha), "1/s");
    columns.column("beta", hdf5::inside(&RingDownRun::damping, &core::RayleighDamping::beta), "s");
    columns.column("frequency", &RingDownRun::frequency, "Hz");
    columns.column("damping_ratio", &RingDownRun::damping_ratio);
    columns.column("swing_error", &RingDownRun::swing_error, "m");
    columns.column("error", &RingDownRun::error, "m");
    columns.column("start_error", &RingDownRun::start_error, "m");
    columns.column("seconds", &RingDownRun::seconds, "s");
    columns.blocks("swings", &RingDownRun::swings, num_swings, "m");
    columns.blocks("displacement", &RingDownRun::displacement, num_vectors, "m");
}

template <class At> void describe_ring_down(At at, Of<At, RingDownResult> &ring_down, std::size_t num_markers) {
    at.text("state", ring_down.state);
    at.number("interval", ring_down.interval);
    at.number("frequency", ring_down.frequency);
    at.number("frequency_uncertainty", ring_down.frequency_uncertainty);
    at.number("damping_ratio", ring_down.damping_ratio);
    at.number("damping_uncertainty", ring_down.damping_uncertainty);
    at.number("swing_noise", ring_down.swing_noise);
    at.number("noise", ring_down.noise);
    at.number("no_motion", ring_down.no_motion);
    at.number("rigid_motion", ring_down.rigid_motion);
    at.rows("swings", ring_down.swings, "m", num_swings);
    at.blocks("displacement", ring_down.displacement, num_markers, "m");
    describe_ringing_runs(at.group("runs"), ring_down.runs, ring_down.displacement.size());
}

template <class At> void describe_force(At at, Of<At, ForceResult> &force) {
    at.text("state", force.state);
    at.text("place", force.place);
    at.number("young_modulus", force.young_modulus);
    at.rows("way", force.way, "m");
    const auto num_ways = force.way.size();
    at.rows("force", force.force, "N", num_ways);
    at.rows("deviation", force.deviation, "N", num_ways);
    if (at.has("uniform", !force.uniform.empty()))
        at.rows("uniform", force.uniform, "N", num_ways);
    auto columns = hdf5::columns_of(at.group("runs"), force.runs);
    columns.texts("models", &ForceRun::model);
    columns.words("statuses", &ForceRun::status);
    columns.texts("messages", &ForceRun::message);
    columns.column("tetrahedra", &ForceRun::tetrahedra);
    columns.column("seconds", &ForceRun::seconds, "s");
    columns.blocks("force", &ForceRun::force, num_ways, "N");
}

template <class At> void describe_fits(At at, Of<At, std::vector<FittedMaterial>> &fits) {
    auto columns = hdf5::columns_of(at, fits);
    columns.texts("models", &FittedMaterial::model, {"model"});
    const auto error = [](double length) { return length_cell(length); };
    columns.column("error", &FittedMaterial::error, "m", {"error [mm]", error});
    columns.column("young_modulus", &FittedMaterial::young_modulus, "Pa",
                   {"best modulus [kPa]", [](double modulus) { return with_decimals(1e-3 * modulus, 1); }});
    columns.column("error_of_modulus", &FittedMaterial::error_of_modulus, "m", {"error then [mm]", error});
    columns.column("poisson_ratio", &FittedMaterial::poisson_ratio, "",
                   {"best ratio", [](double ratio) { return with_decimals(ratio, 3); }});
    columns.column("error_of_ratio", &FittedMaterial::error_of_ratio, "m", {"error then [mm]", error});
}

template <class At> void describe_experiment(At root, Of<At, ExperimentResult> &result) {
    const auto at = root.group("experiment");
    at.text("name", result.name);
    at.text("title", result.title);
    at.text("source", result.source);
    at.text("reference", result.reference);
    at.texts("assumptions", result.assumptions);
    if (at.has("markers", !result.markers.empty())) // forces alone may have been measured
        describe_markers(at.group("markers"), result);
    const auto num_markers = result.markers.size();
    describe_states(at.group("states"), result.states, num_markers);
    describe_runs(at.group("runs"), result.runs, result.states.size(), num_markers);
    describe_deformed_body(at.group("body"), result);
    if (at.has("forces", !result.forces.empty()))
        at.group("forces", hdf5::Order::kept).each(result.forces, [](auto place, auto &force) {
            describe_force(place, force);
        });
    if (at.has("fits", !result.fits.empty()))
        describe_fits(at.group("fits"), result.fits);
    if (!at.has("ring_downs", !result.ring_downs.empty())) // nothing was let go, or the file is of an older version
        return;
    const auto ring_downs = at.group("ring_downs", hdf5::Order::kept);
    ring_downs.text("damping_from", result.damping_from);
    ring_downs.each(result.ring_downs,
                    [&](auto place, auto &ring_down) { describe_ring_down(place, ring_down, num_markers); });
}

std::string cell_of(const ExperimentRun &run) {
    const auto error = length_cell(run.error);
    return run.status == core::SolutionStatus::ok ? error : fmt::format("{} ({})", error, core::to_string(run.status));
}

/// The runs of a model on a mesh, by state.
struct ExperimentRow {
    std::string model;
    int tetrahedra = 0;
    std::vector<const ExperimentRun *> runs;

    /// The larger the worse, with those last that have no solution somewhere.
    double mean_error() const {
        double sum = 0.0;
        for (const auto *run : runs)
            sum += run->status == core::SolutionStatus::ok && std::isfinite(run->error) ? run->error : HUGE_VAL;
        return sum;
    }
};

std::vector<ExperimentRow> rows_of(const ExperimentResult &result) {
    std::vector<ExperimentRow> rows;
    for (const auto &run : result.runs) {
        if (rows.empty() || rows.back().model != run.model || rows.back().tetrahedra != run.tetrahedra)
            rows.push_back({run.model, run.tetrahedra, {}});
        rows.back().runs.push_back(&run);
    }
    std::ranges::stable_sort(rows, {}, &ExperimentRow::mean_error);
    return rows;
}

/// Difference in percent of what was measured, with its sign.
std::string percent_off(double value, double measured) {
    return std::isfinite(value) ? fmt::format("{:+.1f}", 100.0 * (value / measured - 1.0)) : "-";
}

} // namespace

void write_experiment(const std::filesystem::path &path, const ExperimentResult &result) {
    hdf5::write_record(path, result, [](auto root, auto &record) { describe_experiment(root, record); });
}

ExperimentResult read_experiment(const std::filesystem::path &path) {
    return hdf5::read_record<ExperimentResult>(path, "livermark experiment",
                                               [](auto root, auto &record) { describe_experiment(root, record); });
}

Layout experiment_table(const ExperimentResult &result) {
    Layout layout{{{"error [mm]"}, {"tetrahedra", true}}, {}};
    for (const auto &state : result.states)
        layout.columns.push_back({state.name, true});
    layout.columns.push_back({"time [s]", true});
    hdf5::Cells cells;
    describe_states(cells, result.states, result.markers.size());
    const bool has_line = std::ranges::any_of(
        result.states, [](const ExperimentState &state) { return std::isfinite(state.straight_line); });
    const bool has_rigid_motion = std::ranges::any_of(
        result.states, [](const ExperimentState &state) { return std::isfinite(state.rigid_motion); });
    const bool has_affine_map = std::ranges::any_of(
        result.states, [](const ExperimentState &state) { return std::isfinite(state.affine_map); });
    for (const std::string name : {"noise", "no_motion", "rigid_motion", "affine_map", "straight_line", "fit_residual",
                                   "reference_uncertainty"}) {
        if ((!has_line && (name == "straight_line" || name == "fit_residual")) ||
            (!has_rigid_motion && name == "rigid_motion") || (!has_affine_map && name == "affine_map"))
            continue;
        const auto &[head, state_cells] = cells.column(name);
        auto &row = layout.rows.emplace_back(std::vector{head.title, std::string()});
        row.insert(row.end(), state_cells.begin(), state_cells.end());
        row.emplace_back("");
    }
    for (const auto &model_row : rows_of(result)) {
        std::vector<std::string> row{model_row.model, fmt::format("{}", model_row.tetrahedra)};
        double seconds = 0.0;
        for (const auto *run : model_row.runs) {
            row.push_back(cell_of(*run));
            seconds += run->seconds;
        }
        row.push_back(fixed(seconds, 1));
        layout.rows.push_back(std::move(row));
    }
    return layout;
}

Layout fit_table(const ExperimentResult &result) {
    hdf5::Cells cells;
    describe_fits(cells, result.fits);
    return cells.table({"models", "error", "young_modulus", "error_of_modulus", "poisson_ratio", "error_of_ratio"});
}

Layout ring_down_table(const ExperimentResult &result) {
    Layout layout{{{"state"},
                   {"ring-down"},
                   {"tetrahedra", true},
                   {"frequency [Hz]", true},
                   {"off by [%]", true},
                   {"damping ratio", true},
                   {"swings, error [mm]", true},
                   {"markers, error [mm]", true},
                   {"time [s]", true}},
                  {}};
    for (const auto &ring_down : result.ring_downs) {
        const auto add = [&](std::vector<std::string> row) {
            row.insert(row.begin(), printable(ring_down.state));
            row.resize(layout.columns.size());
            layout.rows.push_back(std::move(row));
        };
        add({"measured", "", fixed(ring_down.frequency, 2), "", fixed(ring_down.damping_ratio, 3)});
        add({"uncertainty of that", "", fixed(ring_down.frequency_uncertainty, 2),
             fixed(100.0 * ring_down.frequency_uncertainty / ring_down.frequency, 1),
             fixed(ring_down.damping_uncertainty, 3), in_mm_if_known(ring_down.swing_noise),
             in_mm_if_known(ring_down.noise)});
        if (std::isfinite(ring_down.rigid_motion))
            add({"rigid motion, fitted to each record", "", "", "", "", "", length_cell(ring_down.rigid_motion)});
        add({"no motion", "", "", "", "", "", length_cell(ring_down.no_motion)});
        auto runs = ring_down.runs;
        std::ranges::stable_sort(
            runs, {}, [](const RingDownRun &run) { return std::isfinite(run.error) ? run.error : HUGE_VAL; });
        for (const auto &run : runs)
            add({run.status == core::SolutionStatus::ok
                     ? run.model
                     : fmt::format("{} ({})", run.model, core::to_string(run.status)),
                 std::to_string(run.tetrahedra), with_decimals(run.frequency, 2),
                 percent_off(run.frequency, ring_down.frequency), with_decimals(run.damping_ratio, 3),
                 length_cell(run.swing_error), length_cell(run.error), fixed(run.seconds, 1)});
    }
    return layout;
}

std::string ring_down_note(const ExperimentResult &result) {
    for (const auto &ring_down : result.ring_downs)
        if (ring_down.state == result.damping_from && !ring_down.runs.empty()) {
            const auto &damping = ring_down.runs.back().damping; // of the reference
            return fmt::format(
                "Damping is fitted on {} alone, a ratio of {:.3f} at {:.2f} Hz, and then stays: "
                "alpha = {:.3f} 1/s, beta = {:.3e} s. Interactive methods know damping of the mass alone, "
                "and have the same ratio there.",
                printable(result.damping_from), ring_down.damping_ratio, ring_down.frequency, damping.alpha,
                damping.beta);
        }
    return "";
}

} // namespace livermark::results
