#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/body_sources.hpp"
#include "app/cli/commands.hpp"
#include "app/cli/image_bodies.hpp"
#include "core/mesh/plausible_liver.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/units.hpp"
#include "meshes/cutting/cut_reader.hpp"
#include "meshes/generators/box_generator.hpp"
#include "meshes/generators/liver_generator.hpp"
#include "meshes/generators/liver_shape.hpp"
#include "meshes/generators/liver_vessels.hpp"
#include "meshes/io/body_reader.hpp"
#include "meshes/io/mesh_checks.hpp"
#include "meshes/io/mesh_files.hpp"
#include "meshes/io/vessel_files.hpp"
#include "msm/springs/springs.hpp"
#include "studies/advise/advise.hpp"
#include "studies/models/model_table.hpp"
#include "studies/study.hpp"

namespace livermark::cli {

namespace {

struct CutCommand {
    std::string body;
    meshes::CutWords words;
    std::string output;
};

/// The longest stable steps of some springs before and after: where the surface splits tetrahedra, small ones make them
/// short.
void print_steps(const core::Body &before, const core::Body &after) {
    const auto known = models::all_models();
    const auto step = [&](const core::Body &body, const char *name) {
        const auto springs =
            models::springs_of(support::find_named(known, name, "model"), std::make_shared<const core::Body>(body));
        return core::milliseconds * studies::critical_time_step(body, springs.value().body);
    };
    for (const auto *const name : {"lloyd", "nodal_neo_hookean"})
        fmt::print("longest step      {:.3f} ms before, {:.3f} ms after, of {}\n", step(before, name),
                   step(after, name), name);
}

int make_cut_body(const CutCommand &command, const std::string &command_line) {
    support::check_place(command.output);
    meshes::check_name_of_mesh(command.output);
    const auto cut = meshes::cut_of(command.words, "mesh cut");
    const auto body =
        meshes::read_body(studies::find_toml_files({command.body}, studies::bodies_folder, "body").front());
    print_notes(body.assumptions);
    const auto result = meshes::cut(body, cut);
    print_notes(result.notes);
    for (const auto &file : meshes::write_cut_body(command.output, result, command_line))
        fmt::print("{}\n", file.string());
    fmt::print("{}", meshes::to_text(meshes::mesh_figures(result.body.mesh)));
    fmt::print("removed           {:.3f} mL, {:.3f} g\nwound             {:.2f} cm^2\n", 1e6 * result.removed_volume,
               1e3 * result.removed_mass, 1e4 * result.wound_area);
    if (command.words.margin)
        fmt::print("margin            {:.2f} mm where the wound is nearest, {:.2f} mm were asked for\n",
                   core::millimetres * result.least_margin, core::millimetres * *command.words.margin);
    print_steps(body, result.body);
    return 0;
}

struct LiverCommand {
    meshes::LiverOptions options;
    int variant = 0; ///< 0 is the liver that ships
    std::string output;
    std::string veins{}; ///< file of its veins; none if empty
};

struct BoxCommand {
    std::vector<double> size; // [m]
    double edge = 0.0;        // [m]
    meshes::BoxTopology topology = meshes::BoxTopology::delaunay;
    std::string output;
};

/// Draws the patches and vessels of a body from four sides, and prints which colour is which.
void write_picture(const std::string &body_file, const std::string &picture) {
    support::check_place(picture);
    const auto found = studies::find_toml_files({body_file}, studies::bodies_folder, "body").front();
    const auto body = meshes::read_body(found);
    const support::ScratchFolder scratch;
    const auto mesh = scratch.path / "body.msh", drawn = scratch.path / "picture.png";
    meshes::write_msh(mesh, body.mesh);
    std::vector<std::string> files{mesh.string(), drawn.string()};
    if (body.vessels) {
        files.insert(files.end(), {"--vessels", (scratch.path / "vessels.swc").string()});
        support::write_whole(files.back(), meshes::swc_text(*body.vessels, "vessels of the body"));
    }
    const auto box = core::bounding_box(body.mesh.points);
    if (const auto slices = slices_of_image(found, box.center()); !slices.empty()) {
        files.insert(files.end(), {"--slices", (scratch.path / "slices.json").string()});
        support::write_whole(files.back(), slices);
    }
    const auto legend =
        support::run_python("report.patches", files, {}, "a picture", "python3-matplotlib python3-meshio");
    support::write_whole(picture, support::read_text(drawn));
    fmt::print("\n{}: from the front, from behind, from above and from below\n", picture);
    fmt::print("{}", legend);
}

/// Figures of whatever can be a body. A mesh in MSH is in metres unless it is larger than any organ.
int check_body(const std::string &file) {
    if (!stem_of_image(file).empty()) {
        fmt::print("{}", figures_of_labels(file));
    } else if (meshes::is_surface_file(file)) {
        fmt::print("{}", figures_of_surface(file));
    } else if (support::file_ending(file) == ".msh") {
        std::vector<std::string> remarks;
        auto mesh = meshes::read_mesh(file, remarks);
        if (const double longest = core::bounding_box(mesh.points).sizes().maxCoeff();
            longest > 2.0 && longest <= 2e3) {
            const auto unit = meshes::guess_unit(mesh.points, meshes::mesh_figures(mesh).volume, file);
            for (auto &point : mesh.points)
                point *= unit.metres;
            remarks.push_back(fmt::format("coordinates are assumed to be in {}, {}", unit.unit, unit.remark));
        }
        for (const auto &doubts : {core::doubts_about_unit(mesh.points), core::doubts_about_liver(mesh)})
            remarks.insert(remarks.end(), doubts.begin(), doubts.end());
        const auto orientation = meshes::orientation_remarks(mesh);
        remarks.insert(remarks.end(), orientation.begin(), orientation.end());
        print_notes(remarks);
        fmt::print("{}", meshes::to_text(meshes::mesh_figures(mesh)));
    } else {
        const auto body = meshes::read_body(studies::find_toml_files({file}, studies::bodies_folder, "body").front());
        print_notes(body.assumptions);
        fmt::print("{}", meshes::to_text(meshes::mesh_figures(body.mesh)));
    }
    return 0;
}

int write_mesh(const std::string &output, const core::TetraMesh &mesh) {
    meshes::write_msh(output, mesh);
    fmt::print("{}", meshes::to_text(meshes::mesh_figures(mesh)));
    return 0;
}

void check_mesh_output(const std::string &output) {
    support::check_place(output);
    if (support::file_ending(output) != ".msh")
        throw support::InputError(fmt::format("{}: the mesh is written as MSH; end its name in .msh", output));
}

int make_box(const BoxCommand &command) {
    check_mesh_output(command.output);
    const core::Vector3 size(command.size.at(0), command.size.at(1), command.size.at(2));
    return write_mesh(command.output, meshes::generate_box(size, command.edge, command.topology));
}

int make_liver(const LiverCommand &command, const std::string &command_line) {
    check_mesh_output(command.output);
    if (!command.veins.empty()) {
        if (command.variant != 0)
            throw support::InputError("{}: veins are those of the liver that ships; leave out --variant",
                                      command.veins);
        if (!command.veins.ends_with(".swc"))
            throw support::InputError("{}: veins are written as SWC; end its name in .swc", command.veins);
        support::check_place(command.veins);
        support::write_whole(command.veins, meshes::swc_text(meshes::liver_veins(),
                                                             "Hepatic and portal veins of the livers that ship, made "
                                                             "by `livermark mesh liver --vessels`"));
    }
    if (command.variant != 0) {
        if (command.options.tumours)
            throw support::InputError(
                fmt::format("variant {} of the liver has lesions of its own; leave out --tumours", command.variant));
        const auto variant = meshes::draw_liver(command.variant);
        print_notes({meshes::to_text(variant)});
        const auto mesh = meshes::generate_liver(variant, command.options.target_tetrahedra);
        meshes::write_liver_body(command.output, mesh, variant, command_line);
        fmt::print("{}", meshes::to_text(meshes::mesh_figures(mesh)));
        return 0;
    }
    return write_mesh(command.output, meshes::generate_liver(command.options));
}

/// Options of `livermark mesh` without a subcommand.
struct SegmentationOptions {
    SegmentCommand body;
    PhantomCommand phantom;
    bool is_phantom = false;
    std::string picture; ///< of the patches; none if empty
    std::string ct;
    std::vector<double> thresholds;
    std::string output;
};

int make_of_segmentation(SegmentationOptions options) {
    if (!options.ct.empty())
        throw support::InputError(
            fmt::format("{}: a scan is not a segmentation; segment it with 3D Slicer, TotalSegmentator, MONAI Label or "
                        "ITK-SNAP, and give the label image to --labels",
                        options.ct));
    const int num_sources =
        (options.body.labels.empty() ? 0 : 1) + (options.body.surfaces.empty() ? 0 : 1) + (options.is_phantom ? 1 : 0);
    if (num_sources != 1)
        throw support::InputError(
            "one source is needed; give one of --labels, --surfaces and --phantom, or one of "
            "the subcommands liver, box, cut, stiffness, vessels, unload and check; see `livermark mesh "
            "--help`");
    if (options.output.empty())
        throw support::InputError("no file to write is given; name it with -o");
    if (!options.body.roles.empty() && options.body.labels.empty())
        throw support::InputError("--role is for segments of a label image; give one with --labels");
    options.body.output = options.phantom.output = options.output;
    if (options.is_phantom)
        return make_phantom(options.phantom);
    if (!options.picture.empty())
        support::check_place(options.picture);
    const int status =
        options.body.labels.empty() ? make_body_of_surfaces(options.body) : make_body_of_labels(options.body);
    const auto body_file = std::filesystem::path(options.output).replace_extension(".toml");
    print_notes(meshes::orientation_remarks(body_file));
    if (!options.picture.empty())
        write_picture(body_file.string(), options.picture);
    return status;
}

std::shared_ptr<SegmentationOptions> add_segmentation(CLI::App &command, const std::string &command_line) {
    auto options = std::make_shared<SegmentationOptions>();
    options->body.command_line = command_line;
    command.add_option("--labels", options->body.labels,
                       "A label image: NIfTI, NRRD, MetaImage, a DICOM segmentation, or the folder of a DICOM series");
    command
        .add_option("--liver", options->body.liver,
                    "Labels of the liver's tissue; by default those that are named so, or the lowest one")
        ->delimiter(',')
        ->check(CLI::Range(1, 65535));
    command
        .add_option("--tumours", options->body.tumours,
                    "Labels of lesions; by default those that are named so, or all others")
        ->delimiter(',')
        ->check(CLI::Range(1, 65535));
    command
        .add_option("--role", options->body.roles,
                    "Role of a segment, as NAME=ROLE, where its name says none or another; repeat it for more. NAME is "
                    "its name or label, ROLE is liver, tumour, vessel, vessel_hepatic, vessel_portal, vessel_artery, "
                    "cyst, gallbladder or ignore")
        ->expected(1)
        ->take_all();
    command.add_option(
        "--surfaces", options->body.surfaces,
        "Closed surfaces (STL, OBJ, PLY, OFF, VTK, VTP, or the boundary of a mesh): the liver, then each "
        "lesion");
    command.add_option("--unit", options->body.unit,
                       "Unit of the surfaces: m, cm or mm, or its length in metres, such as 0.025; by default guessed "
                       "from the size");
    command.add_option("--tetrahedra", options->body.tetrahedra, "Approximate number of tetrahedra")
        ->check(CLI::Range(2000, 2000000))
        ->capture_default_str();
    command.add_option("--picture", options->picture,
                       "A .png file to draw the patches and vessels of the body into, and slices of its image with the "
                       "contour of the mesh");
    command.add_flag("--force", options->body.force, "Overwrite an existing body");
    command.add_flag("--phantom", options->is_phantom, "Write a label image of the liver that ships, with its lesions");
    command.add_option("--spacing", options->phantom.spacing, "Size of the phantom's voxels [m]")
        ->expected(3)
        ->capture_default_str();
    command.add_option("--turn", options->phantom.turn, "Rotation vector of the phantom's axes [rad]")
        ->expected(3)
        ->capture_default_str();
    command.add_flag("--touching", options->phantom.touching,
                     "A lesion of the phantom touches the capsule, and another one its neighbour");
    command.add_flag("--vessels", options->phantom.vessels,
                     "The phantom has trunks of hepatic and portal veins, and names of its labels (.nrrd)");
    command.add_option("--scan", options->phantom.scan, "File for a scan of the phantom, beside its labels");
    command.add_option("--stiffness", options->phantom.stiffness,
                       "File for a map of the phantom's shear modulus [Pa], beside its labels");
    command.add_option("--ct", options->ct, "Always refused: a scan has to be segmented first");
    command.add_option("-o,--output", options->output,
                       "The .msh file to write, with a .toml beside it; for --phantom "
                       "a .nii.gz, .nii, .nrrd or .mha");
    for (auto *option : command.get_options())
        if (option != command.get_help_ptr())
            option->group("Bodies of segmentations");
    command.add_option("--threshold", options->thresholds, "")->group("");
    return options;
}

/// `livermark mesh cut`.
/// @param parent        `livermark mesh`
/// @param command_line  kept in the body file
/// @return the command, and the subcommand, which says whether it was asked for
std::pair<Command, CLI::App *> add_mesh_cut(CLI::App &parent, const std::string &command_line) {
    auto options = std::make_shared<CutCommand>();
    auto *command =
        parent.add_subcommand("cut", "Cut a body at rest, and write the remaining body with the patch 'wound'");
    command->add_option("body", options->body, "A name as in 'livermark list bodies', or the path of a body")
        ->required();
    command->add_option("--region", options->words.region, "Remove this region, such as tumour_1");
    command->add_option("--margin", options->words.margin, "Also remove everything nearer to the region than this [m]");
    command
        ->add_option("--half-space", options->words.half_space,
                     "Remove everything beyond a plane: a point [m], and the normal, which points to the removed side")
        ->expected(6);
    command
        ->add_option("--blade", options->words.blade,
                     "Cut along the quadrilateral that a straight blade sweeps: its four corners in turn [m]")
        ->expected(12);
    command->add_option("--thickness", options->words.thickness,
                        "Thickness of the blade [m], which is removed; 0, the default, parts the body");
    command
        ->add_option("--way", options->words.way,
                     "facets (removes whole tetrahedra) or exact (splits tetrahedra at the surface)")
        ->capture_default_str();
    command
        ->add_option("--small-pieces", options->words.small_pieces,
                     "What happens to all but the largest piece: refuse, remove, or keep as bodies of their own")
        ->capture_default_str();
    command->add_option("-o,--output", options->output, "The .msh file to write, with a .toml beside it")->required();
    return {[options, command_line] { return make_cut_body(*options, command_line); }, command};
}

/// `livermark mesh unload`, whose options livermark.studies.unload reads.
/// @param parent  `livermark mesh`
/// @return the command, and the subcommand, which says whether it was asked for
std::pair<Command, CLI::App *> add_mesh_unload(CLI::App &parent) {
    auto *command = parent.add_subcommand(
        "unload", "Find the shape of a scanned body without gravity, by each model, and what ignoring gravity costs");
    command->set_help_flag();
    command->prefix_command();
    return {[command]() -> int {
                support::continue_as_python("studies.unload", command->remaining(), "an unloaded shape",
                                            "python3-numpy");
            },
            command};
}

/// `livermark mesh vessels`.
/// @param parent  `livermark mesh`
/// @return the command, and the subcommand, which says whether it was asked for
std::pair<Command, CLI::App *> add_mesh_vessels(CLI::App &parent) {
    auto options = std::make_shared<VesselsCommand>();
    auto *command = parent.add_subcommand(
        "vessels", "Make lines of the vessels of a label image, for what is thinner than the elements of a body");
    command
        ->add_option("image", options->labels,
                     "A label image: NIfTI, NRRD, MetaImage, a DICOM segmentation, or the folder of a DICOM series")
        ->required();
    command
        ->add_option(
            "--role", options->roles,
            "Role of a segment, as NAME=ROLE, where its name says none or another; repeat it for more. NAME is "
            "its name or label, ROLE is vessel, vessel_hepatic, vessel_portal or vessel_artery for one that "
            "becomes lines, and ignore for one that does not")
        ->expected(1)
        ->take_all();
    command->add_option("--largest-radius", options->largest_radius,
                        "Leave out what is thicker than this [m], such as vessels that the body has as regions");
    command->add_option("-o,--output", options->output,
                        "The .swc file to write; by default it has the name of the image and lies in this folder");
    return {[options] {
                write_vessel_lines(*options);
                return 0;
            },
            command};
}

} // namespace

Command add_mesh(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand("mesh", "Make a body, or check a mesh");
    command->require_subcommand(0, 1);
    const auto segmentation = add_segmentation(*command, command_line);

    auto liver = std::make_shared<LiverCommand>();
    auto *make = command->add_subcommand("liver", "Make the mesh of the liver with gmsh");
    make->add_flag("--tumours", liver->options.tumours, "Give the liver its six lesions");
    make->add_option("--tetrahedra", liver->options.target_tetrahedra, "Approximate number of tetrahedra")
        ->check(CLI::Range(2000, 2000000));
    make->add_option("--variant", liver->variant,
                     "Number of the liver of another person, with its own volume, lobes and lesions; 0 is the liver "
                     "that ships. A body .toml is written beside the mesh")
        ->check(CLI::Range(0, 1000000))
        ->capture_default_str();
    make->add_option(
        "--vessels", liver->veins,
        "A .swc file to write as well: its hepatic and portal veins as lines, for [vessels] in a body .toml");
    make->add_option("-o,--output", liver->output, "The .msh file to write")->required();

    auto box = std::make_shared<BoxCommand>();
    auto *make_a_box = command->add_subcommand("box", "Make the mesh of a box, with a patch for each side");
    make_a_box->add_option("--size", box->size, "Size in x, y and z [m]")->expected(3)->required();
    make_a_box->add_option("--edge", box->edge, "Approximate edge length [m]")->required();
    using enum meshes::BoxTopology;
    make_a_box
        ->add_option("--topology", box->topology,
                     "delaunay (unstructured, by gmsh), body_centred (the regular lattice with the best shapes) or "
                     "kuhn (six tetrahedra in a cube)")
        ->transform(one_of(std::map<std::string, meshes::BoxTopology>{
            {"delaunay", delaunay}, {"body_centred", body_centred}, {"kuhn", kuhn}}))
        ->default_str("delaunay");
    make_a_box->add_option("-o,--output", box->output, "The .msh file to write")->required();

    const auto cut = add_mesh_cut(*command, command_line);

    auto stiffness = std::make_shared<StiffnessCommand>();
    auto *map = command->add_subcommand(
        "stiffness", "Give each tetrahedron of a body the modulus that an image of elastography has there");
    map->add_option("body", stiffness->body,
                    "The .toml of a body in the patient's coordinates (LPS), such as one of a "
                    "segmentation")
        ->required();
    map->add_option(
           "--map", stiffness->map,
           "An image of the modulus: NIfTI, NRRD, MetaImage, or the folder of a DICOM series. Voxels of 0 have "
           "no value")
        ->required();
    map->add_option("--of", stiffness->quantity,
                    "shear (of wave elastography; E = 2 (1 + nu) mu with the region's nu) or young")
        ->check(CLI::IsMember({"shear", "young"}))
        ->capture_default_str();
    map->add_option("--unit", stiffness->unit, "Unit of its values, kPa or Pa")
        ->check(CLI::IsMember({"kPa", "Pa"}))
        ->required();
    map->add_option("-o,--output", stiffness->output, "The .toml file to write, with the moduli beside it")->required();

    const auto vessels = add_mesh_vessels(*command);
    const auto unload = add_mesh_unload(*command);

    auto file = std::make_shared<std::string>();
    auto *check = command->add_subcommand("check", "Check a mesh, a surface or a label image, and print its size");
    check->add_option("file", *file, "A mesh, surface or label image that `livermark run --body` reads")->required();
    auto picture = std::make_shared<std::string>();
    check->add_option("--picture", *picture,
                      "A .png file to draw the patches of a mesh and the vessels of its body into");

    return [=] {
        if (make->parsed())
            return make_liver(*liver, command_line);
        if (make_a_box->parsed())
            return make_box(*box);
        if (map->parsed()) {
            add_stiffness_map(*stiffness, command_line);
            return 0;
        }
        for (const auto &[run, subcommand] : {cut, vessels, unload})
            if (subcommand->parsed())
                return run();
        if (!check->parsed())
            return make_of_segmentation(*segmentation);
        const int status = check_body(*file);
        if (!picture->empty())
            write_picture(*file, *picture);
        return status;
    };
}

} // namespace livermark::cli
