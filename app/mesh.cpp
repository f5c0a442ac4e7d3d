#include <fmt/format.h>
#include <memory>

#include "app/commands.hpp"
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

int make_liver(const LiverCommand &command) {
    const auto mesh = meshes::generate_liver(command.options);
    meshes::write_msh(command.output, mesh);
    fmt::print("{}", meshes::to_text(meshes::mesh_figures(mesh)));
    return 0;
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

    auto file = std::make_shared<std::string>();
    auto *check = command->add_subcommand("check", "Check a .msh file and print its size and quality");
    check->add_option("file", *file, "A .msh file")->required();

    return [=] {
        if (make->parsed())
            return make_liver(*liver);
        fmt::print("{}", meshes::to_text(meshes::mesh_figures(meshes::read_msh(*file))));
        return 0;
    };
}

} // namespace livermark::app
