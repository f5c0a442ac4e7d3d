#include "results/hdf5/files/experiment_file.hpp"

#include "results/hdf5/file_parts.hpp"

namespace livermark::results {

namespace {

using hdf5::Of;

template <class At> void describe_markers(At at, Of<At, ExperimentResult> &result) {
    at.texts("names", result.markers);
    at.texts("drives", result.drives, result.markers.size());
    at.rows("position", result.positions, "m", result.markers.size());
}

template <class At> void describe_states(At at, Of<At, std::vector<ExperimentState>> &states, std::size_t num_markers) {
    auto columns = hdf5::columns_of(at, states);
    columns.texts("names", &ExperimentState::name);
    columns.column("noise", &ExperimentState::noise, "m");
    columns.column("no_motion", &ExperimentState::no_motion, "m");
    columns.column("rigid_motion", &ExperimentState::rigid_motion, "m");
    columns.column("straight_line", &ExperimentState::straight_line, "m");
    columns.column("fit_residual", &ExperimentState::fit_residual, "m");
    columns.column("reference_uncertainty", &ExperimentState::reference_uncertainty, "m");
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
    columns.column("seconds", &ExperimentRun::seconds, "s");
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
    columns.column(
        "alpha", [](auto &run) -> auto & { return run.damping.alpha; }, "1/s");
    columns.column(
        "beta", [](auto &run) -> auto & { return run.damping.beta; }, "s");
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

template <class At> void describe_experiment(At root, Of<At, ExperimentResult> &result) {
    const auto at = root.group("experiment");
    at.text("name", result.name);
    at.text("title", result.title);
    at.text("source", result.source);
    at.text("reference", result.reference);
    at.texts("assumptions", result.assumptions);
    describe_markers(at.group("markers"), result);
    const auto num_markers = result.markers.size();
    describe_states(at.group("states"), result.states, num_markers);
    describe_runs(at.group("runs"), result.runs, result.states.size(), num_markers);
    describe_deformed_body(at.group("body"), result);
    if (!at.has("ring_downs", !result.ring_downs.empty())) // nothing was let go, or the file is of an older version
        return;
    const auto ring_downs = at.group("ring_downs", hdf5::Order::kept);
    ring_downs.text("damping_from", result.damping_from);
    ring_downs.each(result.ring_downs,
                    [&](auto place, auto &ring_down) { describe_ring_down(place, ring_down, num_markers); });
}

} // namespace

void write_experiment(const std::filesystem::path &path, const ExperimentResult &result) {
    hdf5::write_record(path, result, [](auto root, auto &record) { describe_experiment(root, record); });
}

ExperimentResult read_experiment(const std::filesystem::path &path) {
    return hdf5::read_record<ExperimentResult>(path, "livermark experiment",
                                               [](auto root, auto &record) { describe_experiment(root, record); });
}

} // namespace livermark::results
