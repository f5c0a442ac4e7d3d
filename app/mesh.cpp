#include <fmt/format.h>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "app/commands.hpp"
#include "app/usage.hpp"
#include "core/whole_file.hpp"
#include "meshes/box_generator.hpp"
#include "meshes/liver_generator.hpp"
#include "meshes/mesh_figures.hpp"
#include "meshes/msh_reader.hpp"
#include "meshes/msh_writer.hpp"

namespace livermark::app {

namespace {

struct LiverCommand {
    meshes::LiverOptions options;
    std::string output;
};

struct BoxCommand {
    std::vector<double> size; // [m]
    double edge = 0.0;        // [m]
    meshes::BoxTopology topology = meshes::BoxTopology::delaunay;
    std::string output;
};

int write_mesh(const std::string &output, const core::TetraMesh &mesh) {
    meshes::write_msh(output, mesh);
    fmt::print("{}", meshes::to_text(meshes::mesh_figures(mesh)));
    return 0;
}

int make_box(const BoxCommand &command) {
    core::check_place(command.output);
    const core::Vector3 size(command.size.at(0), command.size.at(1), command.size.at(2));
    return write_mesh(command.output, meshes::generate_box(size, command.edge, command.topology));
}

int make_liver(const LiverCommand &command) {
    core::check_place(command.output);
    return write_mesh(command.output, meshes::generate_liver(command.options));
}

} // namespace

Command add_mesh(CLI::App &parent) {
    auto *command = parent.add_subcommand("mesh", "Make a body, or look at the mesh of one");
    command->require_subcommand(1);

    auto liver = std::make_shared<LiverCommand>();
    auto *make = command->add_subcommand("liver", "Make the mesh of the liver with gmsh");
    make->add_flag("--tumours", liver->options.tumours, "With its six lesions");
    make->add_option("--tetrahedra", liver->options.target_tetrahedra, "How many, about")
        ->check(CLI::Range(2000, 2000000));
    make->add_option("-o,--output", liver->output, "The .msh file to write")->required();

    auto box = std::make_shared<BoxCommand>();
    auto *make_a_box = command->add_subcommand("box", "Make the mesh of a box, with a patch for each side");
    make_a_box->add_option("--size", box->size, "In x, y and z [m]")->expected(3)->required();
    make_a_box->add_option("--edge", box->edge, "Length of the edges, about [m]")->required();
    using enum meshes::BoxTopology;
    make_a_box
        ->add_option("--topology", box->topology,
                     "delaunay (unstructured, gmsh), body_centred (the regular lattice of the best shapes) or kuhn "
                     "(six to a cube)")
        ->transform(one_of(std::map<std::string, meshes::BoxTopology>{
            {"delaunay", delaunay}, {"body_centred", body_centred}, {"kuhn", kuhn}}))
        ->default_str("delaunay");
    make_a_box->add_option("-o,--output", box->output, "The .msh file to write")->required();

    auto file = std::make_shared<std::string>();
    auto *check = command->add_subcommand("check", "Check a .msh file and print its size and quality");
    check->add_option("file", *file, "A .msh file")->required();

    return [=] {
        if (make->parsed())
            return make_liver(*liver);
        if (make_a_box->parsed())
            return make_box(*box);
        fmt::print("{}", meshes::to_text(meshes::mesh_figures(meshes::read_msh(*file))));
        return 0;
    };
}

} // namespace livermark::app
