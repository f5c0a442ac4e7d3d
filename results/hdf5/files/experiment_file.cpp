#include "results/hdf5/files/experiment_file.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/files/ring_down_groups.hpp"
#include "results/hdf5/io/hdf5_io.hpp"
#include "results/hdf5/io/read_apart.hpp"
#include "support/input_error.hpp"
#include "support/whole_file.hpp"

namespace livermark::results {

namespace {

using core::Vector3;
using hdf5::InputFile;
using hdf5::OutputFile;

constexpr const char *experiment_group = "/experiment", *markers_group = "/experiment/markers",
                     *states_group = "/experiment/states", *runs_group = "/experiment/runs",
                     *body_group = "/experiment/body";

/// Calls for each number of a state with its name and the member.
template <class Visit> void for_each_number_of_state(Visit visit) {
    visit("noise", &ExperimentState::noise);
    visit("no_motion", &ExperimentState::no_motion);
    visit("rigid_motion", &ExperimentState::rigid_motion);
    visit("straight_line", &ExperimentState::straight_line);
    visit("fit_residual", &ExperimentState::fit_residual);
    visit("reference_uncertainty", &ExperimentState::reference_uncertainty);
}

/// The same of a run, with the units.
template <class Visit> void for_each_number_of_run(Visit visit) {
    visit("state", "", &ExperimentRun::state);
    visit("tetrahedra", "", &ExperimentRun::tetrahedra);
    visit("error", "m", &ExperimentRun::error);
    visit("worst_error", "m", &ExperimentRun::worst_error);
    visit("seconds", "s", &ExperimentRun::seconds);
}

std::string path_in(const char *group, const char *name) {
    return fmt::format("{}/{}", group, name);
}

/// A member of all rows.
template <class Row, class T> std::vector<T> column(const std::vector<Row> &rows, T Row::*member) {
    std::vector<T> values;
    std::ranges::transform(rows, std::back_inserter(values), member);
    return values;
}

/// Vectors of all rows, one behind the other.
template <class Row> std::vector<Vector3> joined(const std::vector<Row> &rows, std::vector<Vector3> Row::*member) {
    std::vector<Vector3> all;
    for (const auto &row : rows)
        all.insert(all.end(), (row.*member).begin(), (row.*member).end());
    return all;
}

/// Gives each row its part of what joined() made.
template <class Row>
void share_out(const std::vector<Vector3> &all, std::vector<Row> &rows, std::vector<Vector3> Row::*member) {
    const auto size = static_cast<std::ptrdiff_t>(rows.empty() ? 0 : all.size() / rows.size());
    auto from = all.begin();
    for (auto &row : rows) {
        (row.*member).assign(from, from + size);
        from += size;
    }
}

} // namespace

void write_experiment(const std::filesystem::path &path, const ExperimentResult &result) {
    OutputFile file;
    hdf5::write_provenance(file, result.provenance);
    file.group(experiment_group);
    file.text(experiment_group, "name", result.name);
    file.text(experiment_group, "title", result.title);
    file.text(experiment_group, "source", result.source);
    file.text(experiment_group, "reference", result.reference);
    file.texts(experiment_group, "assumptions", result.assumptions);
    file.group(markers_group);
    file.texts(markers_group, "names", result.markers);
    file.texts(markers_group, "drives", result.drives);
    file.dataset(path_in(markers_group, "position"), result.positions, "m");
    file.group(states_group);
    file.texts(states_group, "names", column(result.states, &ExperimentState::name));
    for_each_number_of_state([&](const char *name, auto member) {
        file.dataset(path_in(states_group, name), column(result.states, member), "m");
    });
    file.blocks(path_in(states_group, "displacement"), joined(result.states, &ExperimentState::displacement),
                result.markers.size(), "m");
    file.group(runs_group);
    file.texts(runs_group, "models", column(result.runs, &ExperimentRun::model));
    std::vector<std::string> statuses;
    for (const auto &run : result.runs)
        statuses.emplace_back(core::to_string(run.status));
    file.texts(runs_group, "statuses", statuses);
    file.texts(runs_group, "messages", column(result.runs, &ExperimentRun::message));
    for_each_number_of_run([&](const char *name, const char *units, auto member) {
        file.dataset(path_in(runs_group, name), column(result.runs, member), units);
    });
    file.blocks(path_in(runs_group, "displacement"), joined(result.runs, &ExperimentRun::displacement),
                result.markers.size(), "m");
    file.group(body_group);
    file.dataset(path_in(body_group, "points"), result.points, "m");
    file.dataset(path_in(body_group, "boundary_triangles"), result.boundary, "");
    file.blocks(path_in(body_group, "displacement"), joined(result.states, &ExperimentState::deformed),
                result.points.size(), "m");
    hdf5::write_ring_downs(file, result);
    support::write_whole(path, file.image());
}

namespace {

ExperimentResult experiment_in(const std::filesystem::path &path) {
    const InputFile file(path, "livermark experiment");
    hdf5::check_schema(file);
    ExperimentResult result{.provenance = hdf5::read_provenance(file),
                            .name = file.text(experiment_group, "name"),
                            .title = file.text(experiment_group, "title"),
                            .source = file.text(experiment_group, "source"),
                            .assumptions = file.texts(experiment_group, "assumptions"),
                            .reference = file.text(experiment_group, "reference"),
                            .markers = file.texts(markers_group, "names"),
                            .drives = file.texts(markers_group, "drives"),
                            .positions = {},
                            .states = {},
                            .runs = {},
                            .points = file.dataset<Vector3>(path_in(body_group, "points")),
                            .boundary = file.dataset<std::array<int, 3>>(path_in(body_group, "boundary_triangles"))};
    const auto num_markers = result.markers.size(), num_nodes = result.points.size();
    if (result.drives.size() != num_markers)
        file.refuse(markers_group, "has not as many entries in drives as markers");
    result.positions = file.dataset<Vector3>(path_in(markers_group, "position"), num_markers);
    for (const auto &corners : result.boundary)
        for (const int node : corners)
            if (node < 0 || static_cast<std::size_t>(node) >= num_nodes)
                file.refuse(path_in(body_group, "boundary_triangles"), "has a node that the body has not");
    for (const auto &name : file.texts(states_group, "names"))
        result.states.emplace_back().name = name;
    for_each_number_of_state([&](const char *name, auto member) {
        const auto values = file.dataset<double>(path_in(states_group, name), result.states.size());
        for (std::size_t s = 0; s < values.size(); ++s)
            result.states[s].*member = values[s];
    });
    share_out(file.blocks<Vector3>(path_in(states_group, "displacement"), result.states.size(), num_markers),
              result.states, &ExperimentState::displacement);
    share_out(file.blocks<Vector3>(path_in(body_group, "displacement"), result.states.size(), num_nodes), result.states,
              &ExperimentState::deformed);
    const auto models = file.texts(runs_group, "models"), statuses = file.texts(runs_group, "statuses"),
               messages = file.texts(runs_group, "messages");
    if (statuses.size() != models.size() || messages.size() != models.size())
        file.refuse(runs_group, "has not as many statuses and messages as models");
    for (std::size_t r = 0; r < models.size(); ++r) {
        const auto status = hdf5::status_of_word(statuses[r]);
        if (!status)
            file.refuse(runs_group, fmt::format("has a status '{}' that is not known", support::shown(statuses[r])));
        auto &run = result.runs.emplace_back();
        run.model = models[r];
        run.status = *status;
        run.message = messages[r];
    }
    for_each_number_of_run([&](const char *name, const char *, auto member) {
        using Number = std::remove_cvref_t<decltype(std::declval<ExperimentRun>().*member)>;
        const auto values = file.dataset<Number>(path_in(runs_group, name), result.runs.size());
        for (std::size_t r = 0; r < values.size(); ++r)
            result.runs[r].*member = values[r];
    });
    for (const auto &run : result.runs)
        if (run.state < 0 || static_cast<std::size_t>(run.state) >= result.states.size())
            file.refuse(path_in(runs_group, "state"), "has a state that is not there");
    share_out(file.blocks<Vector3>(path_in(runs_group, "displacement"), result.runs.size(), num_markers), result.runs,
              &ExperimentRun::displacement);
    hdf5::read_ring_downs(file, result);
    return result;
}

} // namespace

ExperimentResult read_experiment(const std::filesystem::path &path) {
    return hdf5::read_once_tried(path, [&] { return experiment_in(path); });
}

} // namespace livermark::results
