#include "results/hdf5/result_shapes.hpp"

#include <fmt/format.h>
#include <set>
#include <stdexcept>

namespace livermark::results {

namespace {

void require_size(std::size_t size, std::size_t wanted, const std::string &what) {
    if (size != wanted)
        throw std::invalid_argument(fmt::format("{} has {} entries instead of {}", what, size, wanted));
}

void check_name(const std::string &name) {
    if (name.empty() || name.find_first_of("/.") != std::string::npos)
        throw std::invalid_argument(
            fmt::format("'{}' cannot name a model in a result file; leave out '/' and '.'", name));
}

void check_model(const ModelResult &model, const core::Problem &problem) {
    const std::size_t num_nodes = problem.body->mesh.points.size();
    check_name(model.name);
    require_size(model.solution.displacement.size(), num_nodes, "the displacement of " + model.name);
    require_size(model.solution.reaction.size(), problem.load_case.num_constraints(), "the reaction of " + model.name);
    if (const auto &springs = model.solution.springs) {
        require_size(springs->node_mass.size(), num_nodes, "the node mass of " + model.name);
        require_size(springs->stiffness.size(), springs->edges.size(), "the stiffness of " + model.name);
        require_size(springs->rest_length.size(), springs->edges.size(), "the rest length of " + model.name);
    }
    if (const auto &history = model.solution.history) {
        if (!problem.load_case.release)
            throw std::invalid_argument(
                fmt::format("model {} has a history, and the load case does not depend on time", model.name));
        const std::size_t num_records = history->time.size();
        require_size(num_records, static_cast<std::size_t>(problem.load_case.release->num_steps) + 1,
                     "the history of " + model.name);
        require_size(history->displacement.size(), num_records * problem.load_case.release->probes.size(),
                     "the history of the displacement of " + model.name);
        require_size(history->kinetic_energy.size(), num_records, "the history of the energy of " + model.name);
        require_size(history->strain_energy.size(), num_records, "the history of the energy of " + model.name);
        const std::size_t num_rows = static_cast<std::size_t>(problem.load_case.release->num_frames()) * num_nodes;
        if (!history->frames.empty())
            require_size(history->frames.size(), num_rows, "the list of frames of " + model.name);
        if (model.comparison && model.comparison->history && !model.comparison->history->error.empty())
            require_size(model.comparison->history->error.size(), num_rows, "the error in the frames of " + model.name);
    }
    for (const auto &point : model.solution.path) {
        require_size(point.displacement.size(), num_nodes, "a displacement on the path of " + model.name);
        require_size(point.reaction.size(), problem.load_case.num_constraints(),
                     "a reaction on the path of " + model.name);
    }
    if (model.solution.path.size() > problem.load_case.num_path_points())
        throw std::invalid_argument(
            fmt::format("the path of {} has more points than that of the load case", model.name));
    if (model.comparison && model.comparison->path)
        require_size(model.comparison->path->centroid_error.size(), problem.body->mesh.region_names.size(),
                     "the list of centroids of " + model.name);
    if (model.comparison)
        require_size(model.comparison->error.size(), num_nodes, "the error of " + model.name);
}

void check_modes(const ModelModes &model, std::size_t num_nodes) {
    check_name(model.name);
    require_size(model.modes.shape.size(), model.modes.angular_frequency.size() * num_nodes,
                 "the shape of the modes of " + model.name);
}

} // namespace

void check_shapes(const Result &result) {
    if (!result.problem.body)
        throw std::invalid_argument("a result needs a body");
    const core::TetraMesh &mesh = result.problem.body->mesh;
    const core::LoadCase &load_case = result.problem.load_case;
    require_size(mesh.region.size(), mesh.tetrahedra.size(), "the region of the mesh");
    require_size(mesh.boundary_patch.size(), mesh.boundary_triangles.size(), "the boundary patch of the mesh");
    require_size(result.problem.body->materials.size(), mesh.region_names.size(), "the list of materials");
    require_size(load_case.condition_on.size(), mesh.boundary_triangles.size(), "the conditions of the load case");
    require_size(load_case.value.size(), mesh.boundary_triangles.size(), "the value of the load case");
    if (!load_case.node_factor.empty())
        require_size(load_case.node_factor.size(), mesh.points.size(), "the factor at the nodes of the load case");
    if (!load_case.node_shift.empty())
        require_size(load_case.node_shift.size(), mesh.points.size(), "the shift at the nodes of the load case");
    std::set<std::string> names;
    for (const ModelResult &model : result.models) {
        check_model(model, result.problem);
        if (!names.insert(model.name).second)
            throw std::invalid_argument(fmt::format("model {} is in the result twice", model.name));
    }
    std::set<std::string> names_of_modes;
    for (const ModelModes &model : result.modes) {
        check_modes(model, mesh.points.size());
        if (!names_of_modes.insert(model.name).second)
            throw std::invalid_argument(fmt::format("the modes of {} are in the result twice", model.name));
    }
    for (const ModelResult &model : result.models)
        if (model.comparison && !names.contains(model.comparison->reference))
            throw std::invalid_argument(fmt::format("model {} is compared with {}, which is not in the result",
                                                    model.name, model.comparison->reference));
    if (const auto &uncertainty = result.reference_uncertainty)
        for (const std::string &name : {uncertainty->reference, uncertainty->refined})
            if (!names.contains(name))
                throw std::invalid_argument(
                    fmt::format("the uncertainty of the reference needs {}, which is not in the result", name));
    if (const auto &uncertainty = result.motion_uncertainty)
        for (const std::string &name : {uncertainty->reference, uncertainty->refined})
            if (!names.contains(name))
                throw std::invalid_argument(
                    fmt::format("the uncertainty of motion needs {}, which is not in the result", name));
}

} // namespace livermark::results
