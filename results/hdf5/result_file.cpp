#include "results/hdf5/result_file.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <memory>
#include <new>
#include <set>
#include <span>
#include <stdexcept>

#include "core/mesh/places.hpp"
#include "results/hdf5/record_file.hpp"
#include "results/hdf5/solution_group.hpp"

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
    check_name(model.name);
    const auto check = [&](std::size_t size, std::size_t wanted, const char *what) {
        require_size(size, wanted, fmt::format("{} of {}", what, model.name));
    };
    const auto &[body, load_case] = problem;
    const auto &solution = model.solution;
    const std::size_t num_nodes = body->mesh.points.size();
    const auto num_constraints = static_cast<std::size_t>(load_case.num_constraints());
    check(solution.displacement.size(), num_nodes, "the displacement");
    check(solution.reaction.size(), num_constraints, "the reaction");
    if (const auto &springs = solution.springs) {
        check(springs->node_mass.size(), num_nodes, "the node mass");
        check(springs->stiffness.size(), springs->edges.size(), "the stiffness");
        check(springs->rest_length.size(), springs->edges.size(), "the rest length");
    }
    if (const auto &history = solution.history) {
        if (!load_case.release)
            throw std::invalid_argument(
                fmt::format("model {} has a history, and the load case does not depend on time", model.name));
        const auto num_records = static_cast<std::size_t>(load_case.release->num_steps) + 1;
        check(history->time.size(), num_records, "the history");
        check(history->displacement.size(), num_records * load_case.release->probes.size(),
              "the history of the displacement");
        check(history->kinetic_energy.size(), num_records, "the history of the energy");
        check(history->strain_energy.size(), num_records, "the history of the energy");
        if (!history->frames.empty())
            check(history->frames.size(), num_frame_rows(problem), "the list of frames");
        if (model.comparison && model.comparison->history && !model.comparison->history->error.empty())
            check(model.comparison->history->error.size(), num_frame_rows(problem), "the error in the frames");
    }
    for (const auto &point : solution.path) {
        check(point.displacement.size(), num_nodes, "a displacement on the path");
        check(point.reaction.size(), num_constraints, "a reaction on the path");
    }
    if (solution.path.size() > load_case.num_path_points())
        throw std::invalid_argument(
            fmt::format("the path of {} has more points than that of the load case", model.name));
    if (!model.comparison)
        return;
    check(model.comparison->error.size(), num_nodes, "the error");
    if (const auto &path = model.comparison->path)
        check(path->centroid_error.size(), body->mesh.region_names.size(), "the list of centroids");
}

using hdf5::GroupReader;
using hdf5::GroupWriter;
using hdf5::Of;

void check_volumes(const GroupReader &at, const core::TetraMesh &mesh) {
    const auto volumes = core::tetrahedron_volumes(mesh);
    const auto bad = std::ranges::find_if(volumes, [](double volume) { return !(volume > 0.0); });
    at.check(bad == volumes.end(), "tetrahedra", fmt::format("row {} has no positive volume", bad - volumes.begin()));
}

/// Axes of a body that is turned from LPS.
template <class At> void describe_axes(At at, Of<At, core::BodyAxes> &axes) {
    if (!at.has("axes", !axes.from_lps.isIdentity(0.0)))
        return;
    core::Vector3 left = axes.from_lps.col(0), posterior = axes.from_lps.col(1), superior = axes.from_lps.col(2);
    at.rows_of("axes", "", left, posterior, superior);
    at.finite("axes", std::array{left, posterior, superior});
    if constexpr (At::reads)
        axes.from_lps << left, posterior, superior;
}

template <class At> void describe_capsule(At root, Of<At, std::optional<core::Capsule>> &capsule) {
    root.optional("capsule", capsule, [&](auto &found) {
        const auto at = root.group("capsule");
        at.number("thickness", found.thickness);
        at.number("young_modulus", found.young_modulus);
        if constexpr (At::reads) {
            at.check(found.thickness > 0.0, "thickness", "it has to be positive");
            at.check(found.young_modulus > 0.0, "young_modulus", "it has to be positive");
        }
    });
}

template <class At> void describe_vessels(At root, Of<At, std::optional<core::VesselTree>> &vessels) {
    root.optional("vessels", vessels, [&](auto &found) {
        const auto at = root.group("vessels");
        at.number("wall_ratio", found.wall_ratio);
        at.number("wall_modulus", found.wall_modulus);
        at.rows("points", found.points, "m");
        at.finite("points", found.points);
        at.rows("radius", found.radius, "m", found.points.size());
        at.node_numbers("segments", found.segments, found.points.size());
        if constexpr (At::reads) {
            at.check(found.wall_ratio > 0.0 && found.wall_ratio <= 1.0,
                     "attribute wall_ratio has to be above 0, and 1 at most");
            at.check(found.wall_modulus > 0.0 && std::isfinite(found.wall_modulus),
                     "attribute wall_modulus has to be positive");
            at.check(std::ranges::all_of(found.radius, [](double r) { return r > 0.0 && std::isfinite(r); }), "radius",
                     "has to be positive");
        }
    });
}

template <class At> void describe_body(At root, Of<At, core::Body> &body) {
    auto &mesh = body.mesh;
    root.text("body", body.name);
    const auto at = root.group("mesh");
    if (at.has("assumptions", !body.assumptions.empty()))
        at.texts("assumptions", body.assumptions);
    at.rows("points", mesh.points, "m");
    at.finite("points", mesh.points);
    at.node_numbers("tetrahedra", mesh.tetrahedra, mesh.points.size());
    if constexpr (At::reads)
        check_volumes(at, mesh);
    at.named_indices("region", mesh.region, mesh.region_names, mesh.tetrahedra.size(), 0);
    at.node_numbers("boundary_triangles", mesh.boundary_triangles, mesh.points.size());
    at.named_indices("boundary_patch", mesh.boundary_patch, mesh.patch_names, mesh.boundary_triangles.size(), 0);
    at.on("boundary_patch").number("confidence", body.patch_confidence);
    describe_axes(at, body.axes);
    if (at.has("modulus_factor", !body.modulus_factor.empty())) {
        at.rows("modulus_factor", body.modulus_factor, "", mesh.tetrahedra.size());
        if constexpr (At::reads)
            at.check(std::ranges::all_of(body.modulus_factor,
                                         [](double factor) { return factor > 0.0 && std::isfinite(factor); }),
                     "modulus_factor", "it has to be positive");
    }
    hdf5::describe_materials(root, body.materials, mesh.region_names.size());
    describe_capsule(root, body.capsule);
    describe_vessels(root, body.vessels);
}

template <class At> void describe_modes(At at, Of<At, core::Modes> &modes, std::size_t num_nodes) {
    at.integer("degrees_of_freedom", modes.degrees_of_freedom);
    at.number("seconds", modes.seconds);
    at.rows("angular_frequency", modes.angular_frequency, "rad/s");
    at.blocks("shape", modes.shape, num_nodes, "kg^-1/2", modes.angular_frequency.size());
}

/// Refuses a name that no solution in the file has.
template <class At> void check_solved(At at, const std::string &what, const std::string &name) {
    if constexpr (At::reads)
        at.check(at.file().has(solution_group(name)), fmt::format("{} '{}', which is not in /solutions", what, name));
}

template <class At> void describe_uncertainty(At at, Of<At, ReferenceUncertainty> &uncertainty) {
    at.text("model", uncertainty.reference);
    at.text("refined_model", uncertainty.refined);
    for (const auto &name : {uncertainty.reference, uncertainty.refined})
        check_solved(at, "names the model", name);
    at.number("reference_uncertainty", uncertainty.relative_l2);
    at.number("refinement_difference", uncertainty.refinement_difference);
    at.number("order", uncertainty.order);
    at.number("energy_uncertainty", uncertainty.energy_error);
    at.number("reaction_uncertainty", uncertainty.reaction_error);
    at.number("stiffness_uncertainty", uncertainty.stiffness);
}

template <class At> void describe_motion_uncertainty(At at, Of<At, MotionUncertainty> &uncertainty) {
    at.text("model", uncertainty.reference);
    at.text("refined_model", uncertainty.refined);
    for (const auto &name : {uncertainty.reference, uncertainty.refined})
        check_solved(at, "names the model", name);
    at.number("motion_uncertainty", uncertainty.relative_l2);
    at.number("refinement_difference", uncertainty.difference);
    at.number("order", uncertainty.order);
}

template <class At>
void describe_motion_comparison(At at, Of<At, core::HistoryComparison> &motion, const core::Problem &problem) {
    at.number("history_relative_l2", motion.relative_l2);
    at.number("history_amplitude_error", motion.amplitude_error);
    at.number("history_lag", motion.lag);
    at.text("history_reference", motion.reference);
    at.check(problem.load_case.release.has_value(), "has a history, and /load_case/release is not there");
    const bool is_named = at.has("error_frames_reference", !motion.error.empty());
    if (is_named)
        at.text("error_frames_reference", motion.frames_reference);
    if (!is_named && !at.has("error_frames", false))
        return;
    if constexpr (At::reads)
        if (!is_named)
            motion.frames_reference = motion.reference; // as in earlier files
    at.rows("error_frames", motion.error, "m", num_frame_rows(problem));
}

template <class At> void describe_path_comparison(At at, Of<At, core::PathComparison> &path, std::size_t num_regions) {
    at.number("reaction_bias", path.reaction_bias);
    at.number("worst_reaction_error", path.worst_reaction_error);
    at.number("worst_relative_l2", path.worst_relative_l2);
    at.number("percentile_95", path.percentile_95);
    at.number("volume_error", path.volume_error);
    at.rows("centroid_error", path.centroid_error, "m", num_regions);
}

template <class At> void describe_slow_comparison(At at, Of<At, core::SlowComparison> &slow) {
    at.number("slow_median_error", slow.median_error);
    at.number("slow_worst_error", slow.worst_error);
    at.text("slow_place", slow.place);
    at.number("lost_energy_error", slow.lost_energy);
}

template <class At>
void describe_comparison(At at, Of<At, core::Comparison> &comparison, const core::Problem &problem) {
    at.text("reference", comparison.reference);
    check_solved(at, "attribute reference is", comparison.reference);
    if (at.has("load_fraction", comparison.load_fraction < 1.0))
        at.number("load_fraction", comparison.load_fraction);
    at.number("relative_l2", comparison.relative_l2);
    at.number("max_error", comparison.max_error);
    at.number("max_error_relative", comparison.max_error_relative);
    at.number("energy_error", comparison.energy_error);
    at.number("reaction_error", comparison.reaction_error);
    at.optional("history_relative_l2", comparison.history,
                [&](auto &motion) { describe_motion_comparison(at, motion, problem); });
    at.optional("reaction_bias", comparison.path,
                [&](auto &path) { describe_path_comparison(at, path, problem.body->mesh.region_names.size()); });
    at.optional("slow_worst_error", comparison.slow, [&](auto &slow) { describe_slow_comparison(at, slow); });
    if constexpr (At::reads) {
        if (at.file().has(at.path_of("tool"))) // files of earlier versions have none
            comparison.tool = read_tool_comparison(at, problem.load_case);
    } else if (comparison.tool) {
        write_tool_comparison(at, *comparison.tool, problem.load_case);
    }
    at.rows("error", comparison.error, "m", problem.body->mesh.points.size());
}

/// Quality of a solution. In files of earlier versions it may have a band of expected errors in place of a comparison.
template <class At> void describe_quality(At at, Of<At, ModelResult> &model, const core::Problem &problem) {
    at.optional("reference", model.comparison, [&](auto &comparison) { describe_comparison(at, comparison, problem); });
    at.check(model.comparison || at.has("band_expected"), "has no attribute reference");
}

void write_model(const GroupWriter &root, const ModelResult &model, const Result &result,
                 std::vector<NamedSprings> &written) {
    const auto &problem = result.problem;
    write_solution_group(root.file(), model.name, model.solution, problem.load_case);
    const GroupWriter at(root.file(), solution_group(model.name));
    if (const auto &springs = model.solution.springs) {
        write_springs(root.file(), {at.path(), &*springs}, written);
        written.push_back({at.path(), &*springs});
    }
    if (!problem.load_case.path.empty() || problem.load_case.regime == core::Regime::large) {
        const auto deformation = core::deformation(problem.body->mesh, model.solution.displacement);
        at.number("volume_change", deformation.volume_change);
        at.number("smallest_jacobian", deformation.smallest_jacobian);
        at.integer("inverted_tetrahedra", deformation.num_inverted);
    }
    at.text("summary", model.summary);
    at.text("source", model.source);
    if (!model.comparison)
        return;
    const auto quality = root.on("comparisons").group(model.name);
    describe_quality(quality, model, problem);
    if (result.reference_uncertainty)
        quality.integer("within_uncertainty", is_within_uncertainty(model, result) ? 1 : 0);
}

ModelResult read_model(const GroupReader &root, const std::string &name, const core::Problem &problem) {
    ModelResult model;
    model.name = name;
    const GroupReader at(root.file(), solution_group(name));
    at.text("summary", model.summary);
    at.text("source", model.source);
    model.solution = read_solution_group(root.file(), name, problem);
    if (root.file().has(comparison_group(name)))
        describe_quality(root.on("comparisons").on(name), model, problem);
    return model;
}

/// Parts of a result beside its problem and the models.
template <class At> void describe_rest(At root, Of<At, Result> &result) {
    root.optional("reference", result.reference_uncertainty,
                  [&](auto &uncertainty) { describe_uncertainty(root.group("reference"), uncertainty); });
    root.optional("motion_reference", result.motion_uncertainty,
                  [&](auto &uncertainty) { describe_motion_uncertainty(root.group("motion_reference"), uncertainty); });
    if (root.has("modes", !result.modes.empty()))
        root.group("modes", hdf5::Order::kept).each(result.modes, &ModelModes::name, [&](auto at, auto &model) {
            describe_modes(at, model.modes, result.problem.body->mesh.points.size());
        });
}

std::vector<char> file_image(const Result &result) {
    hdf5::OutputFile file;
    const GroupWriter root(file);
    hdf5::write_provenance(file, result.provenance);
    describe_body(root, *result.problem.body);
    hdf5::write_load_case(file, result.problem.load_case);
    write_tools(file, result.problem);
    root.group("solutions", hdf5::Order::kept);
    root.group("comparisons");
    std::vector<NamedSprings> written;
    for (const ModelResult &model : result.models)
        write_model(root, model, result, written);
    describe_rest(root, result);
    write_vtkhdf(file, result);
    return file.image();
}

Result read_file(const hdf5::InputFile &file) {
    const GroupReader root(file);
    hdf5::check_schema(file);
    Result result;
    result.provenance = hdf5::read_provenance(file);
    auto body = std::make_shared<core::Body>();
    describe_body(root, *body);
    result.problem.load_case =
        hdf5::read_load_case(file, body->mesh.boundary_triangles.size(), body->mesh.points.size());
    result.problem.body = std::move(body);
    for (const std::string &name : file.children("/solutions"))
        result.models.push_back(read_model(root, name, result.problem));
    describe_rest(root, result);
    return result;
}

/// @throws support::InputError where a damaged file claims any size
template <class Read> auto within_memory(const hdf5::InputFile &file, const Read &read) {
    try {
        return read();
    } catch (const std::bad_alloc &) {
        file.refuse("/", "claims more data than fit into memory");
    } catch (const std::length_error &) {
        file.refuse("/", "claims more data than fit into memory");
    }
}

void check_shapes(const Result &result) {
    if (!result.problem.body)
        throw std::invalid_argument("a result needs a body");
    const core::TetraMesh &mesh = result.problem.body->mesh;
    const core::LoadCase &load_case = result.problem.load_case;
    const auto num_nodes = mesh.points.size(), num_triangles = mesh.boundary_triangles.size();
    require_size(mesh.region.size(), mesh.tetrahedra.size(), "the region of the mesh");
    require_size(mesh.boundary_patch.size(), num_triangles, "the boundary patch of the mesh");
    require_size(result.problem.body->materials.size(), mesh.region_names.size(), "the list of materials");
    require_size(load_case.condition_on.size(), num_triangles, "the conditions of the load case");
    require_size(load_case.value.size(), num_triangles, "the value of the load case");
    if (!load_case.node_factor.empty())
        require_size(load_case.node_factor.size(), num_nodes, "the factor at the nodes of the load case");
    if (!load_case.node_shift.empty())
        require_size(load_case.node_shift.size(), num_nodes, "the shift at the nodes of the load case");
    std::set<std::string> names, names_of_modes;
    for (const ModelResult &model : result.models) {
        check_model(model, result.problem);
        if (!names.insert(model.name).second)
            throw std::invalid_argument(fmt::format("model {} is in the result twice", model.name));
    }
    for (const auto &[name, modes] : result.modes) {
        check_name(name);
        require_size(modes.shape.size(), modes.angular_frequency.size() * num_nodes,
                     "the shape of the modes of " + name);
        if (!names_of_modes.insert(name).second)
            throw std::invalid_argument(fmt::format("the modes of {} are in the result twice", name));
    }
    const auto require_model = [&](const std::string &name, const std::string &what) {
        if (!names.contains(name))
            throw std::invalid_argument(fmt::format("{} {}, which is not in the result", what, name));
    };
    for (const ModelResult &model : result.models)
        if (model.comparison)
            require_model(model.comparison->reference, fmt::format("model {} is compared with", model.name));
    if (const auto &uncertainty = result.reference_uncertainty)
        for (const auto &name : {uncertainty->reference, uncertainty->refined})
            require_model(name, "the uncertainty of the reference needs");
    if (const auto &uncertainty = result.motion_uncertainty)
        for (const auto &name : {uncertainty->reference, uncertainty->refined})
            require_model(name, "the uncertainty of motion needs");
}

} // namespace

void write_result(const std::filesystem::path &path, const Result &result) {
    check_shapes(result);
    support::write_whole(path, file_image(result));
}

Result read_result(const std::filesystem::path &path, Origin origin) {
    const auto read = [&] {
        const hdf5::InputFile file(path);
        return within_memory(file, [&] { return read_file(file); });
    };
    return origin == Origin::own ? read() : hdf5::read_once_tried(path, read);
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

core::Solution read_solution(const std::filesystem::path &path, const core::Problem &problem) {
    const hdf5::InputFile file(path);
    return within_memory(file, [&] { return read_solution_group(file, only_solution, problem); });
}

} // namespace livermark::results
