// livermark-segment: what of `livermark` needs ITK and CGAL, which take longer to compile and to load than all the
// rest. `livermark` starts it and prints what it prints; nobody else needs to.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <sys/prctl.h>
#include <unistd.h>
#include <vector>

#include "core/mesh/plausible_liver.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/toml_input.hpp"
#include "meshes/io/body_reader.hpp"
#include "meshes/io/mesh_checks.hpp"
#include "meshes/io/mesh_files.hpp"
#include "meshes/segmentation/images/image_headers.hpp"
#include "meshes/segmentation/images/segmentation.hpp"
#include "meshes/segmentation/images/stiffness_map.hpp"
#include "meshes/segmentation/meshing/patient_body.hpp"
#include "meshes/segmentation/program/image_slices.hpp"
#include "meshes/segmentation/program/vessel_lines.hpp"
#include "meshes/segmentation/surfaces/surface_file.hpp"

/// The work of `livermark-segment`: bodies of segmentations, for `livermark`, which starts it.
namespace livermark::segmentation {

struct BodyCommand {
    std::string labels{};                ///< file, or folder of a DICOM series
    std::vector<int> liver{}, tumours{}; ///< labels
    std::vector<std::string> roles{};    ///< NAME=ROLE
    std::vector<std::string> surfaces{}; ///< files, the liver first
    std::optional<std::string> unit{};   ///< of the surfaces
    int tetrahedra = 0;
    std::string mesh{};         ///< the .msh file; the .toml file goes beside it
    std::string made_of{};      ///< table of the body file
    std::string command_line{}; ///< kept in the body file
};

struct PhantomCommand {
    std::vector<double> spacing, turn; ///< [m], rotation vector [rad]
    bool touching = false, vessels = false;
    std::string output;    ///< label image
    std::string scan;      ///< scan beside it, if there is to be one
    std::string stiffness; ///< the same of a map of its shear modulus
};

struct StiffnessCommand {
    std::string body;     ///< its .toml
    std::string map;      ///< image of a modulus
    std::string quantity; ///< young or shear
    std::string unit;     ///< Pa or kPa
    std::string output;
};

namespace {

namespace fs = std::filesystem;

void tell(const std::string &sentence) {
    fmt::print(stderr, "livermark: {}\n", sentence);
}

void print_quality_criteria(const std::vector<QualityCriterion> &quality_criteria) {
    std::size_t width = 0;
    for (const auto &criterion : quality_criteria)
        width = std::max(width, criterion.name.size());
    fmt::print("\n{:<{}} {:>9} {:>9}\n", "criterion", width, "mesh", "bound");
    for (const auto &criterion : quality_criteria)
        fmt::print("{:<{}} {:>9.3g} {:>9.3g}  {}\n", criterion.name, width, criterion.value, criterion.bound,
                   criterion.is_met      ? "met"
                   : criterion.is_advice ? "warning: " + criterion.remedy
                                         : "MISSED: " + criterion.remedy);
}

/// Prints the volume of each region of the mesh beside that of its voxels, and its material.
void print_regions(const PatientBody &body, const Segmentation &voxels) {
    const auto wanted = region_volumes(voxels);
    const auto tetrahedra = core::tetrahedron_volumes(body.mesh);
    std::vector<double> volumes(wanted.size(), 0.0);
    for (std::size_t t = 0; t < tetrahedra.size(); ++t)
        volumes[static_cast<std::size_t>(body.mesh.region[t])] += tetrahedra[t];
    fmt::print("\n{:<15} {:>11} {:>11} {:>8} {:>8}\n", "region", "voxels [mL]", "mesh [mL]", "off [%]", "E [Pa]");
    for (std::size_t r = 0; r < wanted.size(); ++r)
        fmt::print("{:<15} {:>11.3f} {:>11.3f} {:>8.2f} {:>8.0f}\n", voxels.region_names[r], 1e6 * wanted[r],
                   1e6 * volumes[r], 100.0 * (volumes[r] / wanted[r] - 1.0),
                   default_material(voxels.region_names[r]).material.young_modulus);
}

std::vector<std::string> doubts_about(const Segmentation &voxels) {
    const auto volumes = region_volumes(voxels);
    std::vector<double> lesions;
    for (std::size_t r = 1; r < volumes.size(); ++r)
        if (const auto role = core::role_of_name(voxels.region_names[r]);
            role == core::SegmentRole::lesion || role == core::SegmentRole::cyst)
            lesions.push_back(volumes[r]);
    return core::doubts_about_liver(std::accumulate(volumes.begin(), volumes.end(), 0.0), lesions);
}

int make_body(const BodyCommand &command, const Segmentation &voxels, const std::string &name) {
    for (const auto &remark : voxels.remarks)
        tell(remark);
    for (const auto &doubt : doubts_about(voxels))
        tell(doubt);
    tell(fmt::format("meshing {} regions with about {} tetrahedra", voxels.region_names.size(), command.tetrahedra));
    const auto body = patient_body(voxels, command.tetrahedra);
    const fs::path mesh_file = command.mesh;
    const auto body_file = fs::path(mesh_file).replace_extension(".toml");
    const auto toml =
        body_toml(body, voxels, name, mesh_file.filename().string(), command.command_line) + command.made_of;
    meshes::write_msh(mesh_file, body.mesh);
    support::write_whole(body_file, toml);
    fmt::print("{}{}", meshes::to_text(meshes::mesh_figures(body.mesh)), to_text(body.surface_from_voxels));
    print_regions(body, voxels);
    print_quality_criteria(body.quality_criteria);
    fmt::print("\n{} and {} are written; next: livermark run --body {}\n", mesh_file.string(), body_file.string(),
               body_file.string());
    return all_met(body.quality_criteria) ? 0 : 1;
}

/// Whether the header of an image says where left, back and head are. NIfTI and NRRD may leave it out; DICOM and
/// MetaImage do not.
bool image_says_axes(const fs::path &file) {
    const auto ending = support::file_ending(file);
    if (ending == ".nrrd" || ending == ".nhdr")
        return meshes::first_bytes(file).find("\nspace:") != std::string::npos;
    if (ending != ".nii" && ending != ".gz" && ending != ".hdr" && ending != ".img")
        return true;
    const auto header = read_nifti_header(header_of_pair(file));
    return header && (header->qform_code > 0 || header->sform_code > 0);
}

/// The same of a surface, as 3D Slicer writes it.
bool surface_says_axes(const fs::path &file, const std::vector<std::string> &remarks) {
    return meshes::first_bytes(file).find("SPACE=LPS") != std::string::npos ||
           std::ranges::any_of(remarks, [](const std::string &remark) { return remark.ends_with("turned to LPS"); });
}

/// Metres per unit of the surfaces, said or guessed from the size.
double unit_of(const BodyCommand &command, const meshes::SurfaceMesh &liver, std::vector<std::string> &remarks) {
    if (command.unit)
        return support::metres_per_unit(*command.unit, "--unit");
    const auto guess = meshes::guess_unit(liver.points, meshes::enclosed_volume(liver), command.surfaces.front());
    remarks.push_back(fmt::format("coordinates are assumed to be in {}, {}; --unit sets it", guess.unit, guess.remark));
    return guess.metres;
}

} // namespace

/// Writes the mesh and the body file; remarks go to standard error, the figures of the mesh to standard output.
/// @return the exit status: 1 if a quality criterion was missed that makes numbers wrong; the mesh is written then as
/// well
/// @throws support::InputError
int make_body_of_labels(const BodyCommand &command) {
    const auto image = read_label_image(command.labels);
    LabelChoice choice{command.liver, command.tumours};
    for (const auto &role : command.roles)
        choice.roles.push_back(chosen_role(role));
    auto voxels = choose_labels(image, choice, labelled_volume(image, choice) / command.tetrahedra);
    voxels.is_lps_by_header = image_says_axes(command.labels);
    voxels.patient_position = image.patient_position;
    return make_body(command, voxels, image.name);
}

int make_body_of_surfaces(const BodyCommand &command) {
    std::vector<meshes::SurfaceMesh> surfaces;
    std::vector<std::string> remarks;
    surfaces.push_back(read_surface(command.surfaces.front(), remarks));
    for (const auto &file : std::span(command.surfaces).subspan(1)) {
        auto lesions = read_lesions(file, remarks);
        if (lesions.size() > 1)
            remarks.push_back(fmt::format("{}: its {} closed parts are a lesion each", file, lesions.size()));
        std::ranges::move(lesions, std::back_inserter(surfaces));
    }
    const double unit = unit_of(command, surfaces.front(), remarks);
    for (auto &surface : surfaces)
        for (auto &point : surface.points)
            point *= unit;
    constexpr double voxels_per_edge = 16.0; // fine against the tetrahedra, so that voxels show nowhere
    const double spacing = edge_for(meshes::enclosed_volume(surfaces.front()), command.tetrahedra) / voxels_per_edge;
    auto voxels = voxels_within(surfaces, spacing);
    voxels.remarks.insert(voxels.remarks.begin(), remarks.begin(), remarks.end());
    voxels.is_lps_by_header = surface_says_axes(command.surfaces.front(), remarks);
    return make_body(command, voxels, fs::path(command.surfaces.front()).filename().string());
}

/// The words of `livermark mesh check` on a label image, or of a surface: lines of "name value unit".
/// @throws support::InputError
std::string figures_of_labels(const std::string &file) {
    const auto image = read_label_image(file);
    const auto &grid = image.grid;
    auto text =
        fmt::format("voxels            {} x {} x {}\nspacing           {:.3g} x {:.3g} x {:.3g} mm\n", grid.size[0],
                    grid.size[1], grid.size[2], 1e3 * grid.spacing.x(), 1e3 * grid.spacing.y(), 1e3 * grid.spacing.z());
    std::map<int, std::size_t> num_voxels;
    for (const int label : image.label)
        if (label != 0)
            ++num_voxels[label];
    using core::SegmentRole;
    auto roles = labels_by_role(image);
    const bool has_liver = !roles[SegmentRole::liver].empty(),
               has_names = roles[SegmentRole::unnamed].size() < num_voxels.size();
    double volume = 0.0;
    for (const auto &[role, labels] : roles)
        for (const int label : labels)
            if (!has_liver || role == SegmentRole::liver || role == SegmentRole::lesion || role == SegmentRole::cyst)
                volume += static_cast<double>(num_voxels[label]) * voxel_volume(grid);
    for (const auto &[label, count] : num_voxels) {
        const auto name = image.label_names.find(label);
        text += fmt::format("{:<17} {:.1f} mL{}\n", fmt::format("label {}", label),
                            1e6 * static_cast<double>(count) * voxel_volume(grid),
                            name == image.label_names.end() ? "" : " " + name->second);
    }
    for (const auto &remark : image.remarks)
        tell(remark);
    if (has_names && !has_liver)
        tell("none of the segments is a liver by its name, so it is refused unless --liver gives the label of one");
    for (const auto &doubt : core::doubts_about_liver(volume, {}))
        tell(doubt);
    return text;
}

std::string figures_of_surface(const std::string &file) {
    std::vector<std::string> remarks;
    const auto surface = read_surface(file, remarks);
    const double volume = meshes::enclosed_volume(surface);
    const auto unit = meshes::guess_unit(surface.points, volume, file);
    remarks.push_back(fmt::format("coordinates are assumed to be in {}, {}", unit.unit, unit.remark));
    for (const auto &remark : remarks)
        tell(remark);
    const core::Vector3 extent = 1e3 * unit.metres * core::bounding_box(surface.points).sizes();
    return fmt::format("triangles         {}\ncorners           {}\nvolume            {:.1f} mL\n"
                       "extent            {:.1f} x {:.1f} x {:.1f} mm\nsurface           closed\n",
                       surface.triangles.size(), surface.points.size(),
                       1e6 * volume * unit.metres * unit.metres * unit.metres, extent.x(), extent.y(), extent.z());
}

/// Writes Young's modulus of the tetrahedra of a body [Pa], a line each.
/// @throws support::InputError
int write_moduli(const StiffnessCommand &command) {
    const auto body = meshes::read_body(command.body);
    const StiffnessValues values{.is_shear = command.quantity == "shear", .pascals = command.unit == "kPa" ? 1e3 : 1.0};
    const auto mapped = mapped_modulus(read_stiffness_map(command.map, values), body);
    for (const auto &remark : mapped.remarks)
        tell(remark);
    std::string text = "# Young's modulus of each tetrahedron [Pa]; nan: that of its region\n";
    for (const double modulus : mapped.young_modulus)
        text += fmt::format("{:.6g}\n", modulus);
    support::write_whole(command.output, text);
    return 0;
}

/// Writes the label image of the liver that ships, and a scan of it.
/// @throws support::InputError
int make_phantom(const PhantomCommand &command) {
    const PhantomOptions options{.spacing = {command.spacing.at(0), command.spacing.at(1), command.spacing.at(2)},
                                 .turn = {command.turn.at(0), command.turn.at(1), command.turn.at(2)},
                                 .touching = command.touching,
                                 .vessels = command.vessels};
    write_label_image(command.output, phantom_labels(options));
    fmt::print("{}: liver {}, tumours {} to {}{}\n", command.output, phantom_liver_label, phantom_first_tumour_label,
               phantom_first_tumour_label + 5,
               command.vessels
                   ? fmt::format(", hepatic veins {}, portal vein {}", phantom_hepatic_label, phantom_portal_label)
                   : "");
    if (!command.scan.empty()) {
        write_scan(command.scan, phantom_scan(options));
        fmt::print("{}: grey values [HU]\n", command.scan);
    }
    if (!command.stiffness.empty()) {
        write_scan(command.stiffness, phantom_stiffness(options));
        fmt::print("{}: shear modulus [Pa]\n", command.stiffness);
    }
    return 0;
}

} // namespace livermark::segmentation

namespace {

using livermark::segmentation::BodyCommand;

void add_body_options(CLI::App &command, BodyCommand &body) {
    command.add_option("--tetrahedra", body.tetrahedra)->required();
    command.add_option("--mesh", body.mesh)->required();
    command.add_option("--made-of", body.made_of)->required();
    command.add_option("--command-line", body.command_line)->required();
}

/// Nobody would print what this process has to say once the one that started it is gone.
void end_with(int parent) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) // it went before
        std::raise(SIGTERM);
}

int run(int argc, char **argv) {
    namespace segmentation = livermark::segmentation;
    CLI::App app{"What `livermark` starts to make bodies of segmentations; see `livermark mesh --help`"};
    app.require_subcommand(1);
    BodyCommand body;
    segmentation::PhantomCommand phantom;
    std::string file;
    std::function<int()> action;

    auto *labels = app.add_subcommand("labels", "A body of a label image");
    labels->add_option("file", body.labels)->required();
    labels->add_option("--liver", body.liver)->delimiter(',');
    labels->add_option("--tumours", body.tumours)->delimiter(',');
    labels->add_option("--role", body.roles)->expected(1)->take_all();
    add_body_options(*labels, body);
    labels->callback([&] { action = [&] { return segmentation::make_body_of_labels(body); }; });

    auto *surfaces = app.add_subcommand("surfaces", "A body of closed surfaces");
    surfaces->add_option("files", body.surfaces)->required();
    surfaces->add_option("--unit", body.unit);
    add_body_options(*surfaces, body);
    surfaces->callback([&] { action = [&] { return segmentation::make_body_of_surfaces(body); }; });

    const auto add_figures = [&](const char *name, std::string (*figures)(const std::string &)) {
        auto *command = app.add_subcommand(name, "Its figures");
        command->add_option("file", file)->required();
        command->callback([&action, &file, figures] {
            action = [&file, figures] {
                fmt::print("{}", figures(file));
                return 0;
            };
        });
    };
    add_figures("figures-of-labels", segmentation::figures_of_labels);
    add_figures("figures-of-surface", segmentation::figures_of_surface);

    auto *shipped = app.add_subcommand("phantom", "A label image of the liver that ships");
    shipped->add_option("--spacing", phantom.spacing)->expected(3)->required();
    shipped->add_option("--turn", phantom.turn)->expected(3)->required();
    shipped->add_flag("--touching", phantom.touching);
    shipped->add_flag("--vessels", phantom.vessels);
    shipped->add_option("--scan", phantom.scan);
    shipped->add_option("--stiffness", phantom.stiffness);
    shipped->add_option("--output", phantom.output)->required();
    shipped->callback([&] { action = [&] { return segmentation::make_phantom(phantom); }; });

    segmentation::StiffnessCommand stiffness;
    auto *moduli = app.add_subcommand("stiffness", "Young's modulus of each tetrahedron of a body");
    moduli->add_option("body", stiffness.body)->required();
    moduli->add_option("--map", stiffness.map)->required();
    moduli->add_option("--of", stiffness.quantity)->required();
    moduli->add_option("--unit", stiffness.unit)->required();
    moduli->add_option("--output", stiffness.output)->required();
    moduli->callback([&] { action = [&] { return segmentation::write_moduli(stiffness); }; });

    segmentation::VesselCommand vessels;
    auto *lines = app.add_subcommand("vessels", "Lines of the vessels of a label image");
    lines->add_option("file", vessels.labels)->required();
    lines->add_option("--role", vessels.roles)->expected(1)->take_all();
    lines->add_option("--largest-radius", vessels.largest_radius);
    lines->add_option("--output", vessels.output)->required();
    lines->callback([&] { action = [&] { return segmentation::write_vessel_lines(vessels); }; });

    segmentation::SliceCommand slices;
    auto *planes = app.add_subcommand("slices", "Three planes of a label image");
    planes->add_option("file", slices.labels)->required();
    planes->add_option("--at", slices.at)->delimiter(',')->expected(3)->required();
    planes->add_option("--output", slices.output)->required();
    planes->callback([&] { action = [&] { return segmentation::write_slices(slices); }; });

    segmentation::VoxelCommand voxels;
    auto *volume = app.add_subcommand("voxels", "The voxels around the body of a label image");
    volume->add_option("file", voxels.labels)->required();
    volume->add_option("--liver", voxels.liver)->delimiter(',');
    volume->add_option("--tumours", voxels.tumours)->delimiter(',');
    volume->add_option("--role", voxels.roles)->expected(1)->take_all();
    volume->add_option("--output", voxels.output)->required();
    volume->callback([&] { action = [&] { return segmentation::write_voxels(voxels); }; });

    app.add_option_function<int>("--parent", end_with, "Process that this one ends with");
    CLI11_PARSE(app, argc, argv);
    return action();
}

} // namespace

/// Exit status 2 is that of a refusal, 3 that of a failure; the sentence is all of the standard output then.
int main(int argc, char **argv) {
    std::signal(SIGXFSZ, SIG_IGN); // writing fails as on a full disk
    const livermark::support::UnfailingStandardError standard_error;
    try {
        return run(argc, argv);
    } catch (const livermark::support::InputError &error) {
        fmt::print("{}", error.what());
        return 2;
    } catch (const std::exception &error) {
        fmt::print("{}", error.what());
        return 3;
    }
}
