#include "cli/segment.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <string_view>

#include "cli/body_sources.hpp"
#include "core/bounding_box.hpp"
#include "core/plausible_liver.hpp"
#include "meshes/mesh_figures.hpp"
#include "meshes/mesh_reader.hpp"
#include "meshes/msh_reader.hpp"
#include "meshes/msh_writer.hpp"
#include "segmentation/image_file.hpp"
#include "segmentation/patient_body.hpp"
#include "segmentation/phantom.hpp"
#include "segmentation/surface_file.hpp"
#include "segmentation/surface_voxels.hpp"
#include "support/input_error.hpp"
#include "support/toml_input.hpp"
#include "support/whole_file.hpp"

namespace livermark::cli {

namespace {

namespace fs = std::filesystem;

fs::path body_file_of(const std::string &output) {
    const fs::path mesh = output;
    if (mesh.extension() != ".msh")
        throw support::InputError(fmt::format("{}: the mesh is written as MSH; end its name in .msh", output));
    support::check_place(mesh);
    auto body = mesh;
    body.replace_extension(".toml");
    return body;
}

void tell(const std::string &sentence) {
    fmt::print(stderr, "livermark: {}\n", sentence);
}

void print_quality_criteria(std::FILE *table, const std::vector<segmentation::QualityCriterion> &quality_criteria) {
    std::size_t width = 0;
    for (const auto &criterion : quality_criteria)
        width = std::max(width, criterion.name.size());
    fmt::print(table, "\n{:<{}} {:>9} {:>9}\n", "criterion", width, "mesh", "bound");
    for (const auto &criterion : quality_criteria)
        fmt::print(table, "{:<{}} {:>9.3g} {:>9.3g}  {}\n", criterion.name, width, criterion.value, criterion.bound,
                   criterion.is_met      ? "met"
                   : criterion.is_advice ? "warning: " + criterion.remedy
                                         : "MISSED: " + criterion.remedy);
}

/// What a run is called without what only says to do it again.
std::string without_force(const std::string &command_line) {
    std::string words = command_line;
    constexpr std::string_view flag = " --force";
    for (auto at = words.find(flag); at != std::string::npos; at = words.find(flag))
        words.erase(at, flag.size());
    return words;
}

/// The words behind the program, which may be called by several paths.
std::string arguments_of(const std::string &command_line) {
    const auto space = command_line.find(' ');
    return space == std::string::npos ? "" : without_force(command_line).substr(space);
}

/// Looks whether a body is there already.
/// @return its exit status if the same command has made it of the same files; nothing if it is to be made
std::optional<int> made_before(const SegmentCommand &command, const fs::path &body_file) {
    if (command.force || !fs::exists(body_file))
        return std::nullopt;
    const auto body = support::parse_toml(support::read_text(body_file), body_file);
    const auto generator = body["generator"].value_or(std::string());
    const bool is_same = arguments_of(generator) == arguments_of(command.command_line) && fs::exists(command.output);
    if (!is_same)
        throw support::InputError(fmt::format(
            "{}: there is such a body already, of another command; say --force to write over it, or choose another -o",
            body_file.string()));
    const auto before = sources_in(body_file);
    const auto now = sources_of(command);
    if (!before || !before->is_same_body(now))
        throw support::InputError(
            fmt::format("{}: there is such a body already, and {} has changed since; say --force to make it anew",
                        body_file.string(),
                        fmt::join(command.labels.empty() ? command.surfaces : std::vector{command.labels}, " or ")));
    tell(fmt::format("{} is there, made by the same command; --force makes it anew", body_file.string()));
    fmt::print(command.table, "{}", meshes::to_text(meshes::mesh_figures(meshes::read_msh(command.output))));
    int status = 0;
    if (const auto *gates = body["image"]["gates"].as_array())
        for (const auto &gate : *gates)
            if (const auto *table = gate.as_table())
                if (!(*table)["met"].value_or(true) && !(*table)["advice"].value_or(false))
                    status = 1;
    return status;
}

std::vector<std::string> doubts_about(const segmentation::Segmentation &voxels) {
    const auto volumes = segmentation::region_volumes(voxels);
    return core::doubts_about_liver(std::accumulate(volumes.begin(), volumes.end(), 0.0),
                                    std::span(volumes).subspan(1));
}

int make_body(const SegmentCommand &command, const fs::path &body_file, const segmentation::Segmentation &voxels,
              const std::string &name) {
    for (const auto &remark : voxels.remarks)
        tell(remark);
    for (const auto &doubt : doubts_about(voxels))
        tell(doubt);
    tell(fmt::format("meshing {} regions with about {} tetrahedra", voxels.region_names.size(), command.tetrahedra));
    const auto body = segmentation::patient_body(voxels, command.tetrahedra);
    const fs::path mesh_file = command.output;
    const auto toml = segmentation::body_toml(body, voxels, name, mesh_file.filename().string(),
                                              without_force(command.command_line)) +
                      sources_toml(sources_of(command));
    meshes::write_msh(mesh_file, body.mesh);
    support::write_whole(body_file, toml);
    fmt::print(command.table, "{}", meshes::to_text(meshes::mesh_figures(body.mesh)));
    print_quality_criteria(command.table, body.quality_criteria);
    fmt::print(command.table, "\n{} and {} are written; next: livermark run --body {}\n", mesh_file.string(),
               body_file.string(), body_file.string());
    return segmentation::all_met(body.quality_criteria) ? 0 : 1;
}

/// Metres per unit of the surfaces, said or guessed from the size.
double unit_of(const SegmentCommand &command, const meshes::SurfaceMesh &liver, std::vector<std::string> &remarks) {
    if (command.unit)
        return meshes::metres_per_unit(*command.unit, "--unit");
    const auto guess = meshes::guess_unit(liver.points, meshes::enclosed_volume(liver), command.surfaces.front());
    remarks.push_back(
        fmt::format("coordinates are taken to be in {}, {}; --unit may say another one", guess.unit, guess.remark));
    return guess.metres;
}

} // namespace

int make_body_of_labels(const SegmentCommand &command) {
    const auto body_file = body_file_of(command.output); // refuses before long work
    if (const auto status = made_before(command, body_file))
        return *status;
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
    if (const auto status = made_before(command, body_file))
        return *status;
    std::vector<meshes::SurfaceMesh> surfaces;
    std::vector<std::string> remarks;
    surfaces.push_back(segmentation::read_surface(command.surfaces.front(), remarks));
    for (const auto &file : std::span(command.surfaces).subspan(1)) {
        auto lesions = segmentation::read_lesions(file, remarks);
        if (lesions.size() > 1)
            remarks.push_back(fmt::format("{}: its {} closed parts are a lesion each", file, lesions.size()));
        std::ranges::move(lesions, std::back_inserter(surfaces));
    }
    const double unit = unit_of(command, surfaces.front(), remarks);
    for (auto &surface : surfaces)
        for (auto &point : surface.points)
            point *= unit;
    constexpr double voxels_per_edge = 16.0; // fine against the tetrahedra, so that voxels show nowhere
    const double spacing =
        segmentation::edge_for(meshes::enclosed_volume(surfaces.front()), command.tetrahedra) / voxels_per_edge;
    auto voxels = segmentation::voxels_within(surfaces, spacing);
    voxels.remarks.insert(voxels.remarks.begin(), remarks.begin(), remarks.end());
    return make_body(command, body_file, voxels, fs::path(command.surfaces.front()).filename().string());
}

bool is_surface(const std::string &file) {
    return segmentation::is_surface_file(file);
}

std::string figures_of_labels(const std::string &file) {
    const auto image = segmentation::read_label_image(file);
    const auto &grid = image.grid;
    auto text =
        fmt::format("voxels            {} x {} x {}\nspacing           {:.3g} x {:.3g} x {:.3g} mm\n", grid.size[0],
                    grid.size[1], grid.size[2], 1e3 * grid.spacing.x(), 1e3 * grid.spacing.y(), 1e3 * grid.spacing.z());
    std::map<int, std::size_t> num_voxels;
    for (const int label : image.label)
        if (label != 0)
            ++num_voxels[label];
    double volume = 0.0;
    for (const auto &[label, count] : num_voxels) {
        const double of_label = static_cast<double>(count) * segmentation::voxel_volume(grid);
        const auto name = image.label_names.find(label);
        volume += of_label;
        text += fmt::format("{:<17} {:.1f} mL{}\n", fmt::format("label {}", label), 1e6 * of_label,
                            name == image.label_names.end() ? "" : " " + name->second);
    }
    for (const auto &remark : image.remarks)
        tell(remark);
    for (const auto &doubt : core::doubts_about_liver(volume, {}))
        tell(doubt);
    return text;
}

std::string figures_of_surface(const std::string &file) {
    std::vector<std::string> remarks;
    const auto surface = segmentation::read_surface(file, remarks);
    const double volume = meshes::enclosed_volume(surface);
    const auto unit = meshes::guess_unit(surface.points, volume, file);
    remarks.push_back(fmt::format("coordinates are taken to be in {}, {}", unit.unit, unit.remark));
    for (const auto &remark : remarks)
        tell(remark);
    const core::Vector3 extent = 1e3 * unit.metres * core::bounding_box(surface.points).sizes();
    return fmt::format("triangles         {}\ncorners           {}\nvolume            {:.1f} mL\n"
                       "extent            {:.1f} x {:.1f} x {:.1f} mm\nsurface           closed\n",
                       surface.triangles.size(), surface.points.size(),
                       1e6 * volume * unit.metres * unit.metres * unit.metres, extent.x(), extent.y(), extent.z());
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
