#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/commands.hpp"
#include "app/cli/image_bodies.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "core/units.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/engine_parameters.hpp"
#include "results/tables/table.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/advise/advise.hpp"
#include "studies/study.hpp"

namespace livermark::cli {

namespace {

using core::microseconds;
using core::millimetres;
using core::milliseconds;
using core::percent;

struct AdviseCommand {
    std::vector<std::string> bodies; ///< one, or the surfaces of one
    meshes::MaterialOverride material;
    double tool_radius = studies::fingertip_radius; ///< [m]
    std::optional<double> budget;                   ///< [ms]
    std::string output;
    bool json = false, markdown = false, force = false;
};

void print_body(const studies::BodyFigures &body) {
    const auto &mesh = body.mesh;
    fmt::print("{}: {:.3g} L, {:.0f} x {:.0f} x {:.0f} mm, {} tetrahedra, {} nodes\n", results::printable(body.name),
               1e3 * mesh.volume, millimetres * mesh.extent.x(), millimetres * mesh.extent.y(),
               millimetres * mesh.extent.z(), mesh.num_tetrahedra, mesh.num_nodes);
    for (const auto &region : body.regions)
        fmt::print("  region {}: {:.1f} mL, {} tetrahedra{}; {:g} Pa, Poisson's ratio {:g}, {:g} kg/m^3\n",
                   results::printable(region.name), 1e6 * region.volume, region.num_tetrahedra,
                   region.num_parts > 1 ? fmt::format(" in {} parts", region.num_parts) : "",
                   region.material.young_modulus, region.material.poisson_ratio, region.material.density);
    fmt::print("  edges: {:.1f} mm in the mean, {:.1f} mm on the surface; a tool of {:.3g} mm radius has {:.1f} of "
               "these in its radius\n\n",
               millimetres * mesh.mean_edge, millimetres * body.surface_edge, millimetres * body.tool_radius,
               body.tool_radius_in_edges());
}

std::string percent_or_dash(double error) {
    return std::isnan(error) ? "-" : std::isinf(error) ? "fails" : fmt::format("{:.1f}", percent * error);
}

void print_ranking(const std::string &title, const std::vector<studies::ModelAdvice> &ranking,
                   const std::optional<studies::ExpectedError> &linear, bool markdown) {
    if (ranking.empty())
        return;
    results::Layout layout{{{"model"},
                            {"tool [%]", true},
                            {"worst tool [%]", true},
                            {"large: tool [%]", true},
                            {"L2 [%]", true},
                            {"large: L2 [%]", true},
                            {"critical step [ms]", true},
                            {"take [ms]", true},
                            {"a step [us]", true},
                            {"a frame [ms]", true}},
                           {}};
    const auto errors = [](const studies::ExpectedError &error) -> std::vector<std::string> {
        const auto at_tool = [](double size) { return std::isinf(size) ? "fails" : results::size_cell(size); };
        const auto failed = [](std::size_t count) { return count == 0 ? "" : fmt::format(" ({} failed)", count); };
        return {error.model,
                at_tool(error.at_tool),
                results::stiffness_cell(error.worst_at_tool),
                at_tool(error.large_at_tool),
                percent_or_dash(error.relative_l2) + failed(error.num_failed),
                percent_or_dash(error.large_relative_l2) + failed(error.num_large_failed)};
    };
    for (const auto &[error, summary, cost] : ranking) {
        auto row = errors(error);
        for (auto cell :
             {fmt::format("{:.3f}", milliseconds * cost.critical_time_step),
              fmt::format("{:.3f}", milliseconds * cost.safe_time_step()),
              fmt::format("{:.0f}{}", microseconds * cost.seconds_per_step, cost.is_on_vector_units ? "" : " *"),
              fmt::format("{:.2f}", milliseconds * cost.seconds_per_frame())})
            row.push_back(std::move(cell));
        layout.rows.push_back(std::move(row));
    }
    if (linear) {
        auto row = errors(*linear);
        row.front() += " (to compare)";
        row.resize(layout.columns.size(), "-");
        layout.rows.push_back(std::move(row));
    }
    fmt::print("{}:\n{}{}\n", title, markdown ? "\n" : "", table_text(layout, markdown));
}

bool has_plain_loops(const studies::Advice &advice) {
    const auto is_plain = [](const studies::ModelAdvice &model) { return !model.cost.is_on_vector_units; };
    return std::ranges::any_of(advice.touch, is_plain) || std::ranges::any_of(advice.position, is_plain);
}

void print_source(const studies::Advice &advice) {
    const auto &evidence = advice.evidence;
    fmt::print(
        "tool: expected error of the stiffness at the tool, which is the force of the tool divided by its "
        "displacement: median of absolute values; worst: with its sign, positive: stiffer than the reference; !: "
        "above {:.0f} %, which fingers tell apart. Small loads with tools of {:.1f} to {:.1f} edges in radius\n",
        percent * core::smallest_felt_difference, evidence.least_radius, evidence.largest_radius);
    fmt::print(
        "L2: expected relative error of the displacement over the whole body: median over small loads on {} {}\n",
        evidence.num_bodies, studies::size_in_words("bodies", evidence.tetrahedra));
    if (!evidence.large_reference.empty())
        fmt::print("large: the same under loads of surgical size, at Poisson's ratio {:g}, against {}; models are "
                   "ranked by the larger of both\n",
                   evidence.large_poisson_ratio, evidence.large_reference);
    fmt::print("take: {:g} of the critical step of symplectic Euler, with nothing damped and nothing constrained; a "
               "frame is 1/60 s in such steps. Processor time of one core of this machine, of real steps on this "
               "mesh{}\n",
               msm::default_safety_factor,
               has_plain_loops(advice) ? "; *: there is no kernel on vector units, and plain loops were timed" : "");
    fmt::print("Errors are against {} at Poisson's ratio {:g}, on bodies on which no constant was chosen:\n",
               evidence.reference, evidence.poisson_ratio);
    for (const auto &source : evidence.sources)
        fmt::print("  {}\n", source);
}

void print_advice(const studies::Advice &advice, bool markdown) {
    print_body(advice.body);
    print_ranking("For touch, by the stiffness at the tool", advice.touch, advice.linear_tetrahedra, markdown);
    print_ranking("For position, by the error of the displacement", advice.position, advice.linear_tetrahedra,
                  markdown);
    print_ranking("For engines whose springs have one stiffness on each edge, by the stiffness at the tool",
                  advice.uncoupled, advice.linear_tetrahedra, markdown);
    fmt::print(
        "For a game engine or simulator `livermark springs BODY --for ENGINE` writes the numbers to type in: {}\n\n",
        fmt::join(support::names_of(msm::all_engines()), ", "));
    if (!advice.over_budget.empty())
        fmt::print("Not ranked, because a frame takes longer than {:g} ms: {}\n\n", milliseconds * *advice.budget,
                   fmt::join(advice.over_budget, ", "));
    fmt::print("What matters on this body:\n");
    for (std::size_t c = 0; c < advice.caveats.size(); ++c)
        fmt::print("  {}. {}\n", c + 1, results::printable(advice.caveats[c].text));
    fmt::print("\n");
    if (!advice.left_out.empty())
        fmt::print("Parts of a liver that this body leaves out, and what that costs the reference, median and worst "
                   "(docs/studies/left_out.md):\n");
    for (const auto &part : advice.left_out)
        fmt::print("  {}: tool {:.1f}, {:.1f} %; L2 {:.1f}, {:.1f} %, on {} under {} load cases; to have it: {}\n",
                   part.words, percent * part.at_tool, percent * part.worst_at_tool, percent * part.relative_l2,
                   percent * part.worst_relative_l2, part.body, part.load_cases, part.remedy);
    if (!advice.left_out.empty())
        fmt::print("\n");
    print_source(advice);
}

std::string check_radius(const std::string &text) {
    double radius = 0.0;
    constexpr double least = 1e-4, largest = 1.0;
    return CLI::detail::lexical_cast(text, radius) && radius >= least && radius <= largest
               ? ""
               : fmt::format("'{}' is not a radius of a tool in metres, from {:g} to {:g}; 12 mm are 0.012", text,
                             least, largest);
}

int advise(const AdviseCommand &command, const std::string &command_line) {
    const auto bodies = with_images_meshed(command.bodies, command.output, command_line, command.force);
    if (bodies.size() != 1)
        throw support::InputError(fmt::format("{} bodies are given; name one", bodies.size()));
    const auto file = studies::find_toml_files(bodies, studies::bodies_folder, "body").front();
    const auto body = meshes::read_body(file, command.material);
    print_notes(body.assumptions);
    studies::AdviceOptions options{.tool_radius = command.tool_radius};
    options.is_material_assumed = support::file_ending(file) != ".toml" && !command.material.young_modulus;
    if (command.budget)
        options.budget = *command.budget / milliseconds;
    const auto advice = studies::advise(body, options, print_progress());
    if (command.json)
        fmt::print("{}\n", studies::to_json(advice));
    else
        print_advice(advice, command.markdown);
    return 0;
}

} // namespace

Command add_advise(CLI::App &parent, const std::string &command_line) {
    auto *command =
        parent.add_subcommand("advise", "Describe a body, rank springs for touch and for position, also those with one "
                                        "stiffness on each edge, and print their "
                                        "steps, their cost on this machine, their expected errors, and caveats");
    auto options = std::make_shared<AdviseCommand>();
    add_bodies(*command, options->bodies, "name one");
    command->get_option("--body")->required();
    add_materials(*command, options->material);
    command
        ->add_option("--tool-radius", options->tool_radius,
                     "Radius of the tool that touches the body [m]; by default a fingertip")
        ->check(CLI::Validator(check_radius, "POSITIVE"))
        ->capture_default_str();
    command
        ->add_option("--budget", options->budget,
                     "Processor time for a frame of 1/60 s [ms]; slower models are not ranked")
        ->check(positive_number());
    add_output(*command, options->output, "Folder for the body that is made of a segmentation");
    command->add_flag("--force", options->force,
                      "Mesh a segmentation again, and overwrite its body file in that folder");
    command->add_flag("--json", options->json, "Print JSON, in SI units");
    command->add_flag("--markdown", options->markdown, "Print tables in Markdown");
    return [options, command_line] { return advise(*options, command_line); };
}

} // namespace livermark::cli
