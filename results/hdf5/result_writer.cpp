#include <algorithm>
#include <fmt/format.h>
#include <set>
#include <span>
#include <stdexcept>

#include "core/mesh/deformation.hpp"
#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/hdf5_io.hpp"
#include "results/hdf5/io/schema.hpp"
#include "results/hdf5/io/vtkhdf.hpp"
#include "results/hdf5/load_case_group.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/hdf5/solution_group.hpp"
#include "results/hdf5/tool_group.hpp"
#include "support/whole_file.hpp"

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

/// The reader refuses all of this too, but a file that nobody can read should not come to be.
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

void write_body(hdf5::OutputFile &file, const core::Body &body) {
    file.text("/", "body", body.name);
    file.group("/mesh");
    if (!body.assumptions.empty())
        file.texts("/mesh", "assumptions", body.assumptions);
    file.dataset("/mesh/points", body.mesh.points, "m");
    file.dataset("/mesh/tetrahedra", body.mesh.tetrahedra, "");
    file.dataset("/mesh/region", body.mesh.region, "");
    file.texts("/mesh/region", "names", body.mesh.region_names);
    file.dataset("/mesh/boundary_triangles", body.mesh.boundary_triangles, "");
    file.dataset("/mesh/boundary_patch", body.mesh.boundary_patch, "");
    file.texts("/mesh/boundary_patch", "names", body.mesh.patch_names);
    if (body.patch_confidence)
        file.number("/mesh/boundary_patch", "confidence", *body.patch_confidence);

    hdf5::write_materials(file, body.materials);
}

void write_deformation(hdf5::OutputFile &file, const std::string &group, const core::Deformation &deformation) {
    file.number(group, "volume_change", deformation.volume_change);
    file.number(group, "smallest_jacobian", deformation.smallest_jacobian);
    file.integer(group, "inverted_tetrahedra", deformation.num_inverted);
}

void write_modes(hdf5::OutputFile &file, const ModelModes &model, std::size_t num_nodes) {
    const std::string group = modes_group(model.name);
    file.group(group);
    file.integer(group, "degrees_of_freedom", model.modes.degrees_of_freedom);
    file.number(group, "seconds", model.modes.seconds);
    file.dataset(group + "/angular_frequency", model.modes.angular_frequency, "rad/s");
    file.blocks(group + "/shape", model.modes.shape, num_nodes, "kg^-1/2");
}

void write_uncertainty(hdf5::OutputFile &file, const ReferenceUncertainty &uncertainty) {
    file.group(reference_group);
    file.text(reference_group, "model", uncertainty.reference);
    file.text(reference_group, "refined_model", uncertainty.refined);
    file.number(reference_group, "reference_uncertainty", uncertainty.relative_l2);
    file.number(reference_group, "refinement_difference", uncertainty.refinement_difference);
    file.number(reference_group, "order", uncertainty.order);
    file.number(reference_group, "energy_uncertainty", uncertainty.energy_error);
    file.number(reference_group, "reaction_uncertainty", uncertainty.reaction_error);
    if (uncertainty.stiffness)
        file.number(reference_group, "stiffness_uncertainty", *uncertainty.stiffness);
}

void write_uncertainty(hdf5::OutputFile &file, const MotionUncertainty &uncertainty) {
    const auto &group = motion_reference_group;
    file.group(group);
    file.text(group, "model", uncertainty.reference);
    file.text(group, "refined_model", uncertainty.refined);
    file.number(group, "motion_uncertainty", uncertainty.relative_l2);
    file.number(group, "refinement_difference", uncertainty.difference);
    file.number(group, "order", uncertainty.order);
}

void write_comparison(hdf5::OutputFile &file, const ModelResult &model, const Result &result) {
    const std::string group = comparison_group(model.name);
    file.group(group);
    if (const auto &comparison = model.comparison) {
        file.text(group, "reference", comparison->reference);
        file.number(group, "relative_l2", comparison->relative_l2);
        file.number(group, "max_error", comparison->max_error);
        file.number(group, "max_error_relative", comparison->max_error_relative);
        file.number(group, "energy_error", comparison->energy_error);
        file.number(group, "reaction_error", comparison->reaction_error);
        if (result.reference_uncertainty)
            file.integer(group, "within_uncertainty", is_within_uncertainty(model, result) ? 1 : 0);
        if (const auto &motion = comparison->history) {
            file.number(group, "history_relative_l2", motion->relative_l2);
            file.number(group, "history_amplitude_error", motion->amplitude_error);
            file.number(group, "history_lag", motion->lag);
            file.text(group, "history_reference", motion->reference);
            if (!motion->error.empty()) {
                file.text(group, "error_frames_reference", motion->frames_reference);
                file.dataset(error_frames_of(model.name), motion->error, "m");
            }
        }
        if (const auto &path = comparison->path) {
            file.number(group, "reaction_bias", path->reaction_bias);
            file.number(group, "worst_reaction_error", path->worst_reaction_error);
            file.number(group, "worst_relative_l2", path->worst_relative_l2);
            file.number(group, "percentile_95", path->percentile_95);
            file.number(group, "volume_error", path->volume_error);
            file.dataset(group + "/centroid_error", path->centroid_error, "m");
        }
        if (const auto &slow = comparison->slow) {
            file.number(group, "slow_median_error", slow->median_error);
            file.number(group, "slow_worst_error", slow->worst_error);
            file.text(group, "slow_place", slow->place);
            file.number(group, "lost_energy_error", slow->lost_energy);
        }
        if (comparison->tool)
            write_tool_comparison(file, group, *comparison->tool);
        file.dataset(group + "/error", comparison->error, "m");
    }
    if (model.band) {
        file.number(group, "band_expected", model.band->expected);
        file.number(group, "band_margin", model.band->margin);
        file.text(group, "band_origin", model.band->origin);
        file.integer(group, "in_band", meets_band(model).value() ? 1 : 0);
    }
}

std::vector<char> file_image(const Result &result) {
    hdf5::OutputFile file;
    hdf5::write_provenance(file, result.provenance);
    write_body(file, *result.problem.body);
    hdf5::write_load_case(file, result.problem.load_case);
    write_tools(file, result.problem);
    file.group("/solutions", true);
    file.group("/comparisons");
    std::vector<NamedSprings> written;
    for (const ModelResult &model : result.models) {
        write_solution_group(file, model.name, model.solution, result.problem.load_case);
        if (const auto &springs = model.solution.springs) {
            const NamedSprings named{solution_group(model.name), &*springs};
            write_springs(file, named, written);
            written.push_back(named);
        }
        if (!result.problem.load_case.path.empty() || result.problem.load_case.regime == core::Regime::large)
            write_deformation(file, solution_group(model.name),
                              core::deformation(result.problem.body->mesh, model.solution.displacement));
        file.text(solution_group(model.name), "summary", model.summary);
        file.text(solution_group(model.name), "source", model.source);
        if (model.comparison || model.band)
            write_comparison(file, model, result);
    }
    if (result.reference_uncertainty)
        write_uncertainty(file, *result.reference_uncertainty);
    if (result.motion_uncertainty)
        write_uncertainty(file, *result.motion_uncertainty);
    if (!result.modes.empty())
        file.group("/modes", true);
    for (const ModelModes &model : result.modes)
        write_modes(file, model, result.problem.body->mesh.points.size());
    write_vtkhdf(file, result);
    return file.image();
}

} // namespace

void write_result(const std::filesystem::path &path, const Result &result) {
    check_shapes(result);
    support::write_whole(path, file_image(result));
}

void write_solution(const std::filesystem::path &path, const core::Solution &solution,
                    const core::LoadCase &load_case) {
    hdf5::OutputFile file(hdf5::OutputFile::Storage::plain);
    file.group("/solutions");
    write_solution_group(file, only_solution, solution, load_case);
    if (solution.springs)
        write_springs(file, {solution_group(only_solution), &*solution.springs}, {});
    support::write_whole(path, file.image());
}

} // namespace livermark::results
