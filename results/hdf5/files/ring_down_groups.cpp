#include "results/hdf5/files/ring_down_groups.hpp"

#include <fmt/format.h>
#include <functional>
#include <utility>

#include "results/hdf5/file_parts.hpp"
#include "support/input_error.hpp"

namespace livermark::results::hdf5 {

namespace {

using core::Vector3;

constexpr const char *ring_downs_group = "/experiment/ring_downs";

/// Calls for each number of a ring-down with its name.
template <class RingDown, class Visit> void for_each_number_of_ring_down(RingDown &ring_down, Visit visit) {
    visit("interval", ring_down.interval);
    visit("frequency", ring_down.frequency);
    visit("frequency_uncertainty", ring_down.frequency_uncertainty);
    visit("damping_ratio", ring_down.damping_ratio);
    visit("damping_uncertainty", ring_down.damping_uncertainty);
    visit("swing_noise", ring_down.swing_noise);
    visit("noise", ring_down.noise);
    visit("no_motion", ring_down.no_motion);
    visit("rigid_motion", ring_down.rigid_motion);
}

/// Calls for each number of a run with its name, its units and a function that returns it.
template <class Visit> void for_each_number_of_ringing_run(Visit visit) {
    visit(
        "time_step", "s", [](auto &run) -> auto & { return run.time_step; });
    visit(
        "alpha", "1/s", [](auto &run) -> auto & { return run.damping.alpha; });
    visit(
        "beta", "s", [](auto &run) -> auto & { return run.damping.beta; });
    visit(
        "frequency", "Hz", [](auto &run) -> auto & { return run.frequency; });
    visit(
        "damping_ratio", "", [](auto &run) -> auto & { return run.damping_ratio; });
    visit(
        "swing_error", "m", [](auto &run) -> auto & { return run.swing_error; });
    visit(
        "error", "m", [](auto &run) -> auto & { return run.error; });
    visit(
        "start_error", "m", [](auto &run) -> auto & { return run.start_error; });
    visit(
        "seconds", "s", [](auto &run) -> auto & { return run.seconds; });
}

template <class T, class Rows, class Value> std::vector<T> column_of(const Rows &rows, Value value) {
    std::vector<T> column;
    for (const auto &row : rows)
        column.emplace_back(std::invoke(value, row));
    return column;
}

/// Vectors of all rows, one behind the other.
template <class T>
std::vector<T> values_of_runs(const std::vector<RingDownRun> &runs, std::vector<T> RingDownRun::*member) {
    std::vector<T> all;
    for (const auto &run : runs)
        all.insert(all.end(), (run.*member).begin(), (run.*member).end());
    return all;
}

/// Gives each run its part of what values_of_runs() made.
template <class T>
void give_parts(const std::vector<T> &all, std::size_t size, std::vector<RingDownRun> &runs,
                std::vector<T> RingDownRun::*member) {
    for (std::size_t r = 0; r < runs.size(); ++r)
        (runs[r].*member)
            .assign(all.begin() + static_cast<std::ptrdiff_t>(r * size),
                    all.begin() + static_cast<std::ptrdiff_t>((r + 1) * size));
}

void write_ringing_runs(OutputFile &file, const std::string &group, const RingDownResult &ring_down) {
    const auto &runs = ring_down.runs;
    file.group(group);
    file.texts(group, "models", column_of<std::string>(runs, &RingDownRun::model));
    file.texts(group, "statuses",
               column_of<std::string>(runs, [](const RingDownRun &run) { return core::to_string(run.status); }));
    file.texts(group, "messages", column_of<std::string>(runs, &RingDownRun::message));
    file.texts(group, "integrators", column_of<std::string>(runs, &RingDownRun::integrator));
    file.dataset(group + "/tetrahedra", column_of<int>(runs, &RingDownRun::tetrahedra), "");
    for_each_number_of_ringing_run([&](const char *name, const char *units, auto value) {
        file.dataset(fmt::format("{}/{}", group, name), column_of<double>(runs, value), units);
    });
    file.blocks(group + "/swings", values_of_runs(runs, &RingDownRun::swings), num_swings, "m");
    file.blocks(group + "/displacement", values_of_runs(runs, &RingDownRun::displacement),
                ring_down.displacement.size(), "m");
}

std::vector<RingDownRun> read_ringing_runs(const InputFile &file, const std::string &group, std::size_t num_vectors) {
    std::vector<RingDownRun> runs;
    const auto statuses = file.texts(group, "statuses"), messages = file.texts(group, "messages"),
               integrators = file.texts(group, "integrators");
    for (const auto &model : file.texts(group, "models"))
        runs.emplace_back().model = model;
    if (statuses.size() != runs.size() || messages.size() != runs.size() || integrators.size() != runs.size())
        file.refuse(group, "has not as many statuses, messages and integrators as models");
    const auto tetrahedra = file.dataset<int>(group + "/tetrahedra", runs.size());
    for (std::size_t r = 0; r < runs.size(); ++r) {
        const auto status = status_of_word(statuses[r]);
        if (!status)
            file.refuse(group, fmt::format("has a status '{}' that is not known", support::shown(statuses[r])));
        runs[r].status = *status;
        runs[r].message = messages[r];
        runs[r].integrator = integrators[r];
        runs[r].tetrahedra = tetrahedra[r];
    }
    for_each_number_of_ringing_run([&](const char *name, const char *, auto value) {
        const auto values = file.dataset<double>(fmt::format("{}/{}", group, name), runs.size());
        for (std::size_t r = 0; r < runs.size(); ++r)
            value(runs[r]) = values[r];
    });
    give_parts(file.blocks<double>(group + "/swings", runs.size(), num_swings), num_swings, runs, &RingDownRun::swings);
    give_parts(file.blocks<Vector3>(group + "/displacement", runs.size(), num_vectors), num_vectors, runs,
               &RingDownRun::displacement);
    return runs;
}

} // namespace

void write_ring_downs(OutputFile &file, const ExperimentResult &result) {
    if (result.ring_downs.empty())
        return;
    file.group(ring_downs_group, true);
    file.text(ring_downs_group, "damping_from", result.damping_from);
    for (std::size_t n = 0; n < result.ring_downs.size(); ++n) {
        const auto &ring_down = result.ring_downs[n];
        const auto group = fmt::format("{}/{}", ring_downs_group, n);
        file.group(group);
        file.text(group, "state", ring_down.state);
        for_each_number_of_ring_down(ring_down,
                                     [&](const char *name, double value) { file.number(group, name, value); });
        file.dataset(group + "/swings", ring_down.swings, "m");
        file.blocks(group + "/displacement", ring_down.displacement, result.markers.size(), "m");
        write_ringing_runs(file, group + "/runs", ring_down);
    }
}

void read_ring_downs(const InputFile &file, ExperimentResult &result) {
    if (!file.has(ring_downs_group))
        return;
    result.damping_from = file.text(ring_downs_group, "damping_from");
    for (const auto &name : file.children(ring_downs_group)) {
        const auto group = fmt::format("{}/{}", ring_downs_group, name);
        auto &ring_down = result.ring_downs.emplace_back();
        ring_down.state = file.text(group, "state");
        for_each_number_of_ring_down(ring_down, [&](const char *of, double &value) { value = file.number(group, of); });
        ring_down.swings = file.dataset<double>(group + "/swings", num_swings);
        ring_down.displacement = file.blocks<Vector3>(group + "/displacement", result.markers.size());
        ring_down.runs = read_ringing_runs(file, group + "/runs", ring_down.displacement.size());
    }
}

std::optional<core::SolutionStatus> status_of_word(const std::string &word) {
    using enum core::SolutionStatus;
    for (const auto status : {ok, diverged, not_converged})
        if (word == core::to_string(status))
            return status;
    return std::nullopt;
}

} // namespace livermark::results::hdf5
