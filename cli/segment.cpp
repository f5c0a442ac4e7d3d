#include "cli/segment.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>

#include "meshes/mesh_figures.hpp"
#include "meshes/mesh_reader.hpp"
#include "meshes/msh_writer.hpp"
#include "segmentation/image_file.hpp"
#include "segmentation/patient_body.hpp"
#include "segmentation/phantom.hpp"
#include "segmentation/surface_file.hpp"
#include "support/input_error.hpp"
#include "support/whole_file.hpp"

namespace livermark::cli {

namespace {

namespace fs = std::filesystem;

/// The body file beside a mesh; somebody may have put materials into one that is there.
fs::path body_file_of(const std::string &output) {
    const fs::path mesh = output;
    if (mesh.extension() != ".msh")
        throw support::InputError(fmt::format("{}: the mesh is written as MSH; end its name in .msh", output));
    support::check_place(mesh);
    auto body = mesh;
    body.replace_extension(".toml");
    if (fs::exists(body))
        throw support::InputError(
            fmt::format("{}: there is such a body already; remove it or choose another -o", body.string()));
    return body;
}

void tell(const std::string &sentence) {
    fmt::print(stderr, "livermark: {}\n", sentence);
}

void print_quality_criteria(std::FILE *table, const std::vector<segmentation::QualityCriterion> &quality_criteria) {
    std::size_t width = 0;
    for (const auto &quality_criterion : quality_criteria)
        width = std::max(width, quality_criterion.name.size());
    fmt::print(table, "\n{:<{}} {:>9} {:>9}\n", "criterion", width, "mesh", "bound");
    for (const auto &quality_criterion : quality_criteria)
        fmt::print(table, "{:<{}} {:>9.3g} {:>9.3g}  {}\n", quality_criterion.name, width, quality_criterion.value,
                   quality_criterion.bound, quality_criterion.is_met ? "met" : "MISSED: " + quality_criterion.remedy);
}

int make_body(const SegmentCommand &command, const fs::path &body_file, const segmentation::Segmentation &voxels,
              const std::string &name) {
    for (const auto &remark : voxels.remarks)
        tell(remark);
    tell(fmt::format("meshing {} regions with about {} tetrahedra", voxels.region_names.size(), command.tetrahedra));
    const auto body = segmentation::patient_body(voxels, command.tetrahedra);
    const fs::path mesh_file = command.output;
    const auto toml = segmentation::body_toml(body, voxels, name, mesh_file.filename().string(), command.command_line);
    meshes::write_msh(mesh_file, body.mesh);
    support::write_whole(body_file, toml);
    fmt::print(command.table, "{}", meshes::to_text(meshes::mesh_figures(body.mesh)));
    print_quality_criteria(command.table, body.quality_criteria);
    fmt::print(command.table, "\n{} and {} are written; next: livermark run --body {}\n", mesh_file.string(),
               body_file.string(), body_file.string());
    return segmentation::all_met(body.quality_criteria) ? 0 : 1;
}

/// Metres per unit of the surfaces, said or guessed from the size.
double unit_of(const SegmentCommand &command, const meshes::SurfaceMesh &liver) {
    if (command.unit)
        return meshes::metres_per_unit(*command.unit, "--unit");
    core::TetraMesh points;
    points.points = liver.points;
    const auto unit = meshes::guess_unit(points, command.surfaces.front());
    tell(fmt::format("coordinates are taken to be in {}, from the size; --unit may say another one", unit));
    return meshes::metres_per_unit(unit, command.surfaces.front());
}

} // namespace

int make_body_of_labels(const SegmentCommand &command) {
    const auto body_file = body_file_of(command.output); // refuses before long work
    const auto image = segmentation::read_label_image(command.labels);
    std::size_t labelled = 0;
    for (const auto label : image.label)
        labelled += label != 0 ? 1 : 0;
    // A lesion below the size of a tetrahedron cannot be resolved by the mesh.
    const double smallest_lesion =
        static_cast<double>(labelled) * segmentation::voxel_volume(image.grid) / command.tetrahedra;
    return make_body(command, body_file,
                     segmentation::choose_labels(image, {command.liver, command.tumours}, smallest_lesion), image.name);
}

int make_body_of_surfaces(const SegmentCommand &command) {
    const auto body_file = body_file_of(command.output);
    std::vector<meshes::SurfaceMesh> surfaces;
    for (const auto &file : command.surfaces)
        surfaces.push_back(segmentation::read_surface(file));
    const double unit = unit_of(command, surfaces.front());
    for (auto &surface : surfaces)
        for (auto &point : surface.points)
            point *= unit;
    constexpr double voxels_per_edge = 16.0; // fine against the tetrahedra, so that voxels show nowhere
    const double spacing =
        segmentation::edge_for(meshes::enclosed_volume(surfaces.front()), command.tetrahedra) / voxels_per_edge;
    return make_body(command, body_file, segmentation::voxels_within(surfaces, spacing),
                     fs::path(command.surfaces.front()).filename().string());
}

int make_phantom(const PhantomCommand &command) {
    for (const double spacing : command.spacing)
        if (!(spacing >= 0.1e-3 && spacing <= 20e-3))
            throw support::InputError(
                fmt::format("--spacing is {} m; give three lengths between 0.0001 and 0.02 m", spacing));
    const segmentation::PhantomOptions options{
        .spacing = {command.spacing.at(0), command.spacing.at(1), command.spacing.at(2)},
        .turn = {command.turn.at(0), command.turn.at(1), command.turn.at(2)},
        .touching = command.touching};
    if (!command.scan.empty())
        support::check_place(command.scan);
    segmentation::write_label_image(command.output, segmentation::phantom_labels(options));
    fmt::print("{}: liver {}, tumours {} to {}\n", command.output, segmentation::phantom_liver_label,
               segmentation::phantom_first_tumour_label, segmentation::phantom_first_tumour_label + 5);
    if (!command.scan.empty()) {
        segmentation::write_scan(command.scan, segmentation::phantom_scan(options));
        fmt::print("{}: grey values [HU]\n", command.scan);
    }
    return 0;
}

} // namespace livermark::cli
