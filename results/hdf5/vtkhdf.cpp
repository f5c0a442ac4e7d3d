#include <algorithm>

#include "results/hdf5/solution_group.hpp"

namespace livermark::results {

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

void write_mesh(hdf5::OutputFile &file, const core::TetraMesh &mesh) {
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
    file.hard_link("/mesh/region", "/VTKHDF/CellData/region");
}

/// One mesh for all steps, so every offset into it is zero.
void write_steps(hdf5::OutputFile &file, const Steps &steps) {
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
    file.dataset(steps_group + "/CellDataOffsets/region", same_place, "");
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
    write_mesh(file, mesh);
    if (moves)
        write_steps(file, steps);

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
              has_frames(model)         ? frames_of(model.name)
              : has_path(model, result) ? path_group(model.name) + "/displacement"
                                        : "");
        if (const auto &comparison = model.comparison)
            array("error_" + model.name, comparison_group(model.name) + "/error",
                  comparison->history && !comparison->history->error.empty() ? error_frames_of(model.name) : "");
    }
}

} // namespace livermark::results
