#include "results/hdf5/solution_group.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <vector>

#include "results/hdf5/record_file.hpp"

namespace livermark::results {

namespace {

using hdf5::Of;

template <class At>
void describe_history(At at, Of<At, core::History> &history, const core::LoadCase &load_case, std::size_t num_nodes) {
    at.check(load_case.release.has_value(), "is there, and /load_case/release is not");
    const auto &release = load_case.release.value();
    const auto num_records = static_cast<std::size_t>(release.num_steps) + 1;
    at.number("setup_seconds", history.setup_seconds);
    at.number("solve_seconds", history.solve_seconds);
    at.text("integrator", history.integrator);
    at.text("kernel", history.kernel);
    if (at.has("forces_per_step")) // files of earlier versions have none
        at.integer("forces_per_step", history.forces_per_step, 0);
    at.number("time_step", history.time_step);
    at.number("critical_time_step", history.critical_time_step);
    at.number("diverged_at", history.diverged_at);
    at.optional("observed_order", history.observed_error, [&](auto &error) {
        at.number("observed_order", error.order);
        at.number("observed_difference", error.difference);
        at.number("observed_l2", error.relative_l2);
    });
    at.rows("time", history.time, "s", num_records);
    at.blocks("displacement", history.displacement, release.probes.size(), "m", num_records);
    at.rows("kinetic_energy", history.kinetic_energy, "J", num_records);
    at.rows("strain_energy", history.strain_energy, "J", num_records);
    if (at.has("frames", !history.frames.empty())) // references that are stored have none
        at.rows("frames", history.frames, "m", static_cast<std::size_t>(release.num_frames()) * num_nodes);
}

template <class At>
void describe_path(At at, Of<At, std::vector<core::PathPoint>> &path, const core::LoadCase &load_case,
                   std::size_t num_nodes) {
    auto points = hdf5::columns_of(at, path);
    points.column("strain_energy", &core::PathPoint::strain_energy, "J");
    at.check(!path.empty() && path.size() <= load_case.num_path_points(),
             fmt::format("has {} points, and /load_case/path or /load_case/slow_history {}", path.size(),
                         load_case.num_path_points()));
    points.rows("displacement", &core::PathPoint::displacement, num_nodes, "m");
    points.blocks("reaction", &core::PathPoint::reaction, static_cast<std::size_t>(load_case.num_constraints()), "N");
    if (!load_case.slow_history)
        return;
    points.column("work", &core::PathPoint::work, "J");
    points.column("dissipated_energy", &core::PathPoint::dissipated_energy, "J");
}

/// The springs of models are often the same in all but one field: what an earlier model has gets a second name.
template <class At>
void describe_springs(At at, Of<At, core::SpringNetwork> &springs, std::size_t num_nodes,
                      std::span<const NamedSprings> earlier) {
    const auto has_second_name = [&]([[maybe_unused]] const std::string &name, [[maybe_unused]] auto field) {
        if constexpr (!At::reads)
            for (const auto &other : earlier)
                if (other.springs->*field == springs.*field) {
                    at.file().hard_link(hdf5::path_below(other.group, name), at.path_of(name));
                    return true;
                }
        return false;
    };
    using Springs = core::SpringNetwork;
    if (!has_second_name("node_mass", &Springs::node_mass))
        at.rows("node_mass", springs.node_mass, "kg", num_nodes);
    if (!has_second_name("edges", &Springs::edges))
        at.node_numbers("edges", springs.edges, num_nodes);
    if (!has_second_name("stiffness", &Springs::stiffness))
        at.rows("stiffness", springs.stiffness, "N/m", springs.edges.size());
    if (!has_second_name("rest_length", &Springs::rest_length))
        at.rows("rest_length", springs.rest_length, "m", springs.edges.size());
}

/// All but the springs.
template <class At>
void describe_solution(At at, Of<At, core::Solution> &solution, const core::LoadCase &load_case,
                       std::size_t num_nodes) {
    at.word("status", solution.status);
    at.text("message", solution.message);
    if (at.has("solver")) // files of earlier versions have none
        at.text("solver", solution.solver);
    at.integer("degrees_of_freedom", solution.degrees_of_freedom);
    at.number("setup_seconds", solution.setup_seconds);
    at.number("solve_seconds", solution.solve_seconds);
    at.number("strain_energy", solution.strain_energy);
    if (at.has("load_work", !std::isnan(solution.load_work)))
        at.number("load_work", solution.load_work);
    at.number("nonlinearity", solution.nonlinearity);
    at.optional("critical_time_step", solution.explicit_steps, [&](auto &steps) {
        at.number("critical_time_step", steps.critical_time_step);
        at.number("seconds_per_step", steps.seconds_per_step);
        at.text("kernel", steps.kernel);
    });
    at.optional("observed_order", solution.observed_error, [&](auto &error) {
        at.number("observed_order", error.order);
        at.number("observed_difference", error.difference);
        at.number("observed_l2", error.relative_l2);
        at.number("observed_energy", error.energy);
        at.number("observed_reaction", error.reaction);
        if (at.has("observed_load_fraction")) // files of earlier versions have none
            at.number("observed_load_fraction", error.load_fraction);
        at.number("observed_stiffness", error.stiffness);
    });
    at.rows("displacement", solution.displacement, "m", num_nodes);
    at.rows("reaction", solution.reaction, "N", static_cast<std::size_t>(load_case.num_constraints()));
    auto patches = load_case.constraint_names();
    at.on("reaction").texts("patches", patches);
    at.check(patches == load_case.constraint_names(), "reaction",
             "attribute patches differs from the names of /load_case/constraint");
    if (at.has("path", !solution.path.empty()))
        describe_path(at.group("path"), solution.path, load_case, num_nodes);
    at.optional("history", solution.history,
                [&](auto &history) { describe_history(at.group("history"), history, load_case, num_nodes); });
}

/// Errors of all places at one point of the path, then at the next.
std::vector<double> point_by_point(const std::vector<core::PlaceErrors> &places) {
    std::vector<double> path;
    for (std::size_t k = 0; !places.empty() && k < places.front().path.size(); ++k)
        for (const auto &place : places)
            path.push_back(place.path[k]);
    return path;
}

/// @param at  /comparisons/<model>/tool
template <class At>
void describe_tool_errors_of(At at, hdf5::Of<At, std::vector<core::PlaceErrors>> &places,
                             const core::LoadCase &load_case) {
    auto columns = hdf5::columns_of(at, places);
    columns.column("stiffness", &core::PlaceErrors::stiffness);
    hdf5::columns_of(at.on("stiffness"), places, places.size()).texts("places", &core::PlaceErrors::name);
    at.check(!places.empty(), "stiffness", "is empty");
    columns.column("relative_l2", &core::PlaceErrors::relative_l2);
    auto path = point_by_point(places);
    if (!at.has("path", !path.empty()))
        return;
    at.blocks("path", path, places.size());
    const auto num_points = path.size() / places.size();
    at.check(num_points <= load_case.num_path_points(), "path",
             fmt::format("has {} points, and /load_case/path {}", num_points, load_case.num_path_points()));
    if constexpr (At::reads)
        for (std::size_t n = 0; n < path.size(); ++n)
            places[n % places.size()].path.push_back(path[n]);
}

} // namespace

void write_springs(hdf5::OutputFile &file, const NamedSprings &model, std::span<const NamedSprings> earlier) {
    describe_springs(hdf5::GroupWriter(file, model.group), *model.springs, model.springs->node_mass.size(), earlier);
}

void write_solution_group(hdf5::OutputFile &file, const std::string &model, const core::Solution &solution,
                          const core::LoadCase &load_case) {
    file.group(solution_group(model));
    describe_solution(hdf5::GroupWriter(file, solution_group(model)), solution, load_case,
                      solution.displacement.size());
}

core::Solution read_solution_group(const hdf5::InputFile &file, const std::string &model,
                                   const core::Problem &problem) {
    const hdf5::GroupReader at(file, solution_group(model));
    const auto num_nodes = problem.body->mesh.points.size();
    core::Solution solution;
    describe_solution(at, solution, problem.load_case, num_nodes);
    at.optional("edges", solution.springs, [&](auto &springs) { describe_springs(at, springs, num_nodes, {}); });
    return solution;
}

std::size_t num_frame_rows(const core::Problem &problem) {
    return static_cast<std::size_t>(problem.load_case.release->num_frames()) * problem.body->mesh.points.size();
}

void write_tools(hdf5::OutputFile &file, const core::Problem &problem) {
    using Place = core::ToolPlace;
    const auto places = core::tool_places(problem.body->mesh, problem.load_case);
    if (places.empty())
        return;
    const auto at = hdf5::GroupWriter(file, "/load_case").group("tool");
    at.number("radius_in_edges", core::radius_in_edges(places).value());
    auto columns = hdf5::columns_of(at, places);
    columns.column("drive", &Place::drive);
    hdf5::columns_of(at.on("drive"), places).texts("places", &Place::name);
    columns.column("middle", &Place::middle, "m");
    columns.column("radius", &Place::radius, "m");
    columns.column("edge_length", &Place::edge_length, "m");
    if (const auto contact = core::contact_radii_in_edges(problem.body->mesh, problem.load_case); !contact.empty())
        at.rows("contact_radius_in_edges", contact, "", contact.size());
}

void write_tool_comparison(const hdf5::GroupWriter &at, const core::ToolComparison &tool,
                           const core::LoadCase &load_case) {
    at.number("stiffness_at_tool", tool.stiffness());
    at.number("relative_l2_at_tool", tool.worst_place().relative_l2);
    at.text("tool", tool.worst_place().name);
    if (!tool.places.front().path.empty())
        at.number("worst_stiffness_at_tool", tool.worst_stiffness());
    describe_tool_errors_of(at.group("tool"), tool.places, load_case);
}

core::ToolComparison read_tool_comparison(const hdf5::GroupReader &at, const core::LoadCase &load_case) {
    core::ToolComparison tool;
    describe_tool_errors_of(at.on("tool"), tool.places, load_case);
    return tool;
}

namespace {

constexpr std::uint8_t vtk_tetra = 10;
constexpr int nodes_per_tetrahedron = 4;
const std::string steps_group = "/VTKHDF/Steps";

bool has_frames(const ModelResult &model) {
    return model.solution.history && !model.solution.history->frames.empty();
}

bool moves_in_time(const Result &result) {
    return result.problem.load_case.release && std::ranges::any_of(result.models, has_frames);
}

/// Steps of a motion are its frames, and the path to its start is not shown.
bool has_path(const ModelResult &model, const Result &result) {
    const auto num_points = result.problem.load_case.num_path_points();
    return !moves_in_time(result) && num_points > 0 && model.solution.path.size() == num_points;
}

/// Steps of a file: the frames of a motion, the times of a slow history, or the points of a path of loads.
struct Steps {
    std::vector<double> values;
    std::string units;
};

Steps steps_of(const Result &result) {
    const auto &load_case = result.problem.load_case;
    if (moves_in_time(result)) {
        const auto &release = load_case.release;
        std::vector<double> time;
        for (int step = 0; step < release->num_frames(); ++step)
            time.push_back(step * release->records_per_frame() * release->output_interval);
        return {std::move(time), "s"};
    }
    if (std::ranges::any_of(result.models, [&](const auto &model) { return has_path(model, result); }))
        return load_case.slow_history ? Steps{load_case.slow_history->times, "s"} : Steps{load_case.path, {}};
    return {};
}

/// Begin of each step in an array: `stride` rows further on, or always at the same place.
std::vector<std::int64_t> step_offsets(int num_steps, int stride) {
    std::vector<std::int64_t> offsets;
    for (int step = 0; step < num_steps; ++step)
        offsets.push_back(static_cast<std::int64_t>(step) * stride);
    return offsets;
}

/// Datasets of /mesh that are shown on tetrahedra.
std::vector<std::string> cell_data_of(const core::Body &body) {
    if (body.modulus_factor.empty())
        return {"region"};
    return {"region", "modulus_factor"};
}

void write_mesh(hdf5::OutputFile &file, const core::Body &body) {
    const auto &mesh = body.mesh;
    std::vector<std::int64_t> connectivity;
    std::vector<std::int64_t> offsets{0};
    connectivity.reserve(nodes_per_tetrahedron * mesh.tetrahedra.size());
    offsets.reserve(mesh.tetrahedra.size() + 1);
    for (const auto &nodes : mesh.tetrahedra) {
        connectivity.insert(connectivity.end(), nodes.begin(), nodes.end());
        offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    }
    file.dataset("/VTKHDF/NumberOfPoints", std::vector<std::int64_t>{mesh.num_nodes()}, "");
    file.dataset("/VTKHDF/NumberOfCells", std::vector<std::int64_t>{mesh.num_tetrahedra()}, "");
    file.dataset("/VTKHDF/NumberOfConnectivityIds", std::vector{static_cast<std::int64_t>(connectivity.size())}, "");
    file.hard_link("/mesh/points", "/VTKHDF/Points");
    file.dataset("/VTKHDF/Connectivity", connectivity, "");
    file.dataset("/VTKHDF/Offsets", offsets, "");
    file.dataset("/VTKHDF/Types", std::vector<std::uint8_t>(mesh.tetrahedra.size(), vtk_tetra), "");
    file.group("/VTKHDF/CellData");
    for (const auto &name : cell_data_of(body))
        file.hard_link("/mesh/" + name, "/VTKHDF/CellData/" + name);
}

/// One mesh for all steps, so every offset into it is zero.
void write_steps(hdf5::OutputFile &file, const Steps &steps, const std::vector<std::string> &cell_data) {
    const int num_steps = static_cast<int>(steps.values.size());
    const auto same_place = step_offsets(num_steps, 0);
    file.group(steps_group);
    file.integer(steps_group, "NSteps", num_steps);
    file.dataset(steps_group + "/Values", steps.values, steps.units);
    file.dataset(steps_group + "/NumberOfParts", std::vector<std::int64_t>(steps.values.size(), 1), "");
    file.dataset(steps_group + "/PartOffsets", same_place, "");
    file.dataset(steps_group + "/PointOffsets", same_place, "");
    file.blocks(steps_group + "/CellOffsets", same_place, 1, "");
    file.blocks(steps_group + "/ConnectivityIdOffsets", same_place, 1, "");
    file.group(steps_group + "/CellDataOffsets");
    for (const auto &name : cell_data)
        file.dataset(fmt::format("{}/CellDataOffsets/{}", steps_group, name), same_place, "");
    file.group(steps_group + "/PointDataOffsets");
}

} // namespace

void write_vtkhdf(hdf5::OutputFile &file, const Result &result) {
    const core::TetraMesh &mesh = result.problem.body->mesh;
    const auto steps = steps_of(result);
    const bool moves = !steps.values.empty();
    file.group("/VTKHDF");
    file.ascii("/VTKHDF", "Type", "UnstructuredGrid");
    file.integers("/VTKHDF", "Version", {moves ? 2 : 1, 0});
    write_mesh(file, *result.problem.body);
    if (moves)
        write_steps(file, steps, cell_data_of(*result.problem.body));

    file.group("/VTKHDF/PointData");
    const auto array = [&](const std::string &name, const std::string &fixed, const std::string &frames) {
        file.hard_link(frames.empty() ? fixed : frames, "/VTKHDF/PointData/" + name);
        if (moves)
            file.dataset(steps_group + "/PointDataOffsets/" + name,
                         step_offsets(static_cast<int>(steps.values.size()), frames.empty() ? 0 : mesh.num_nodes()),
                         "");
    };
    for (const ModelResult &model : result.models) {
        array("displacement_" + model.name, solution_group(model.name) + "/displacement",
              has_frames(model)         ? solution_group(model.name) + "/history/frames"
              : has_path(model, result) ? solution_group(model.name) + "/path/displacement"
                                        : "");
        if (const auto &comparison = model.comparison)
            array("error_" + model.name, comparison_group(model.name) + "/error",
                  comparison->history && !comparison->history->error.empty()
                      ? comparison_group(model.name) + "/error_frames"
                      : "");
    }
}

} // namespace livermark::results
