#include "cli/mesh_cut.hpp"

#include <fmt/format.h>
#include <memory>
#include <string>
#include <utility>

#include "cli/progress.hpp"
#include "cli/usage.hpp"
#include "core/units.hpp"
#include "meshes/cutting/cut_body_file.hpp"
#include "meshes/cutting/cut_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "meshes/io/mesh_figures.hpp"
#include "models/mass_spring_model.hpp"
#include "models/model_table.hpp"
#include "studies/advise/step_cost.hpp"
#include "studies/catalogue.hpp"
#include "support/known_names.hpp"
#include "support/whole_file.hpp"

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

} // namespace

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

} // namespace livermark::cli
