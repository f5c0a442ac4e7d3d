#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/hdf5_io.hpp"
#include "results/hdf5/io/node_numbers.hpp"
#include "results/hdf5/io/read_apart.hpp"
#include "results/hdf5/io/schema.hpp"
#include "results/hdf5/load_case_group.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/hdf5/solution_group.hpp"
#include "results/hdf5/tool_group.hpp"

namespace livermark::results {

namespace {

using hdf5::InputFile;

core::TetraMesh read_mesh(const InputFile &file) {
    core::TetraMesh mesh;
    mesh.points = file.dataset<core::Vector3>("/mesh/points");
    hdf5::check_finite(file, "/mesh/points", mesh.points);
    mesh.tetrahedra = hdf5::node_numbers<4>(file, "/mesh/tetrahedra", mesh.points.size());
    const auto volumes = core::tetrahedron_volumes(mesh);
    const auto bad = std::ranges::find_if(volumes, [](double volume) { return !(volume > 0.0); });
    if (bad != volumes.end())
        file.refuse("/mesh/tetrahedra", fmt::format("row {} has no positive volume", bad - volumes.begin()));
    mesh.region_names = file.texts("/mesh/region", "names");
    mesh.region = hdf5::indices(file, "/mesh/region", mesh.tetrahedra.size(), 0, mesh.region_names.size());
    mesh.boundary_triangles = hdf5::node_numbers<3>(file, "/mesh/boundary_triangles", mesh.points.size());
    mesh.patch_names = file.texts("/mesh/boundary_patch", "names");
    mesh.boundary_patch =
        hdf5::indices(file, "/mesh/boundary_patch", mesh.boundary_triangles.size(), 0, mesh.patch_names.size());
    return mesh;
}

core::Modes read_modes(const InputFile &file, const std::string &group, std::size_t num_nodes) {
    core::Modes modes;
    modes.degrees_of_freedom = file.integer(group, "degrees_of_freedom");
    modes.seconds = file.number(group, "seconds");
    modes.angular_frequency = file.dataset<double>(group + "/angular_frequency");
    modes.shape = file.blocks<core::Vector3>(group + "/shape", modes.angular_frequency.size(), num_nodes);
    return modes;
}

core::Comparison read_comparison(const InputFile &file, const std::string &model, const core::Problem &problem) {
    const std::string group = comparison_group(model);
    core::Comparison comparison;
    comparison.reference = file.text(group, "reference");
    if (!file.has(solution_group(comparison.reference)))
        file.refuse(group,
                    fmt::format("attribute reference is '{}', which is not in /solutions", comparison.reference));
    comparison.relative_l2 = file.number(group, "relative_l2");
    comparison.max_error = file.number(group, "max_error");
    comparison.max_error_relative = file.number(group, "max_error_relative");
    comparison.energy_error = file.number(group, "energy_error");
    comparison.reaction_error = file.number(group, "reaction_error");
    if (file.has_attribute(group, "history_relative_l2")) {
        if (!problem.load_case.release)
            file.refuse(group, "has a history, and /load_case/release is not there");
        comparison.history = {.reference = file.text(group, "history_reference"),
                              .relative_l2 = file.number(group, "history_relative_l2"),
                              .amplitude_error = file.number(group, "history_amplitude_error"),
                              .lag = file.number(group, "history_lag")};
        if (file.has_attribute(group, "error_frames_reference") || file.has(error_frames_of(model))) {
            comparison.history->frames_reference = file.has_attribute(group, "error_frames_reference")
                                                       ? file.text(group, "error_frames_reference")
                                                       : comparison.history->reference; // as in earlier files
            comparison.history->error = file.dataset<Eigen::Vector3f>(error_frames_of(model), num_frame_rows(problem));
        }
    }
    if (file.has_attribute(group, "reaction_bias"))
        comparison.path = {.reaction_bias = file.number(group, "reaction_bias"),
                           .worst_reaction_error = file.number(group, "worst_reaction_error"),
                           .worst_relative_l2 = file.number(group, "worst_relative_l2"),
                           .percentile_95 = file.number(group, "percentile_95"),
                           .volume_error = file.number(group, "volume_error"),
                           .centroid_error =
                               file.dataset<double>(group + "/centroid_error", problem.body->mesh.region_names.size())};
    if (file.has_attribute(group, "slow_worst_error"))
        comparison.slow = {.median_error = file.number(group, "slow_median_error"),
                           .worst_error = file.number(group, "slow_worst_error"),
                           .place = file.text(group, "slow_place"),
                           .lost_energy = file.number(group, "lost_energy_error")};
    if (file.has(group + "/tool")) // files of earlier versions have none
        comparison.tool = read_tool_comparison(file, group, problem.load_case);
    comparison.error = file.dataset<core::Vector3>(group + "/error", problem.body->mesh.points.size());
    return comparison;
}

ModelResult read_model(const InputFile &file, const std::string &name, const core::Problem &problem) {
    ModelResult model;
    model.name = name;
    const std::string solution = solution_group(name);
    model.summary = file.text(solution, "summary");
    model.source = file.text(solution, "source");
    model.solution = read_solution_group(file, name, problem);
    const std::string comparison = comparison_group(name);
    if (!file.has(comparison))
        return model;
    // A model that could not be compared may have a band all the same: the one that it missed.
    if (file.has_attribute(comparison, "reference") || !file.has_attribute(comparison, "band_expected"))
        model.comparison = read_comparison(file, name, problem);
    if (file.has_attribute(comparison, "band_expected")) {
        model.band = {file.number(comparison, "band_expected"), file.number(comparison, "band_margin"),
                      file.text(comparison, "band_origin")};
        if (!(model.band->expected >= 0.0 && model.band->margin > 0.0))
            file.refuse(comparison, "attributes band_expected and band_margin are no band");
    }
    return model;
}

ReferenceUncertainty read_uncertainty(const InputFile &file) {
    ReferenceUncertainty uncertainty;
    uncertainty.reference = file.text(reference_group, "model");
    uncertainty.refined = file.text(reference_group, "refined_model");
    for (const std::string &name : {uncertainty.reference, uncertainty.refined})
        if (!file.has(solution_group(name)))
            file.refuse(reference_group, fmt::format("names the model '{}', which is not in /solutions", name));
    uncertainty.relative_l2 = file.number(reference_group, "reference_uncertainty");
    uncertainty.refinement_difference = file.number(reference_group, "refinement_difference");
    uncertainty.order = file.number(reference_group, "order");
    uncertainty.energy_error = file.number(reference_group, "energy_uncertainty");
    uncertainty.reaction_error = file.number(reference_group, "reaction_uncertainty");
    if (file.has_attribute(reference_group, "stiffness_uncertainty"))
        uncertainty.stiffness = file.number(reference_group, "stiffness_uncertainty");
    return uncertainty;
}

MotionUncertainty read_motion_uncertainty(const InputFile &file) {
    const auto &group = motion_reference_group;
    MotionUncertainty uncertainty;
    uncertainty.reference = file.text(group, "model");
    uncertainty.refined = file.text(group, "refined_model");
    for (const std::string &name : {uncertainty.reference, uncertainty.refined})
        if (!file.has(solution_group(name)))
            file.refuse(group, fmt::format("names the model '{}', which is not in /solutions", name));
    uncertainty.relative_l2 = file.number(group, "motion_uncertainty");
    uncertainty.difference = file.number(group, "refinement_difference");
    uncertainty.order = file.number(group, "order");
    return uncertainty;
}

Result read_file(const InputFile &file) {
    hdf5::check_schema(file);
    Result result;
    result.provenance = hdf5::read_provenance(file);
    auto body = std::make_shared<core::Body>();
    body->name = file.text("/", "body");
    body->mesh = read_mesh(file);
    body->materials = hdf5::read_materials(file, body->mesh.region_names.size());
    if (file.has_attribute("/mesh", "assumptions"))
        body->assumptions = file.texts("/mesh", "assumptions");
    if (file.has_attribute("/mesh/boundary_patch", "confidence"))
        body->patch_confidence = file.number("/mesh/boundary_patch", "confidence");
    result.problem.load_case =
        hdf5::read_load_case(file, body->mesh.boundary_triangles.size(), body->mesh.points.size());
    result.problem.body = std::move(body);
    for (const std::string &name : file.children("/solutions"))
        result.models.push_back(read_model(file, name, result.problem));
    if (file.has(reference_group))
        result.reference_uncertainty = read_uncertainty(file);
    if (file.has(motion_reference_group))
        result.motion_uncertainty = read_motion_uncertainty(file);
    if (file.has("/modes"))
        for (const std::string &name : file.children("/modes"))
            result.modes.push_back(
                {name, read_modes(file, modes_group(name), result.problem.body->mesh.points.size())});
    return result;
}

/// @throws support::InputError where a damaged file claims any size
template <class Read> auto within_memory(const InputFile &file, const Read &read) {
    try {
        return read();
    } catch (const std::bad_alloc &) {
        file.refuse("/", "claims more data than fit into memory");
    } catch (const std::length_error &) {
        file.refuse("/", "claims more data than fit into memory");
    }
}

} // namespace

Result read_result(const std::filesystem::path &path, Origin origin) {
    const auto read = [&] {
        const InputFile file(path);
        return within_memory(file, [&] { return read_file(file); });
    };
    return origin == Origin::own ? read() : hdf5::read_once_tried(path, read);
}

core::Solution read_solution(const std::filesystem::path &path, const core::Problem &problem) {
    const InputFile file(path);
    return within_memory(file, [&] { return read_solution_group(file, only_solution, problem); });
}

} // namespace livermark::results
