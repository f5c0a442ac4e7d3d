#include <fmt/format.h>
#include <map>
#include <memory>

#include "cli/commands/commands.hpp"
#include "cli/common_options.hpp"
#include "cli/image_bodies.hpp"
#include "cli/progress.hpp"
#include "cli/usage.hpp"
#include "core/units.hpp"
#include "meshes/io/body_reader.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/msm_choice.hpp"
#include "studies/parameters/body_parameters.hpp"
#include "studies/run/problems.hpp"
#include "studies/seed_paper/seed_paper.hpp"

namespace livermark::cli {

namespace {

struct ParametersOptions {
    std::vector<std::string> bodies;
    std::string law = "lloyd";
    std::string load_case; ///< empty: see studies::read_constrained_problems()
    meshes::MaterialOverride material;
    studies::DampingChoice damping;
    bool markdown = false;
};

using core::percent;
constexpr int num_compared_modes = 5;

std::string number(double value) {
    return fmt::format("{:.5g}", value);
}

/// Signed, in per cent of the first.
std::string change(double from, double to) {
    return fmt::format("{:+.2f}", percent * (to / from - 1.0));
}

void print_grid(const results::Layout &grid, bool markdown) {
    fmt::print("{}\n", markdown ? results::to_markdown(grid) : results::to_text(grid));
}

void print_spreads(const studies::BodyParameters &body, bool markdown) {
    results::Layout grid{{{"parameter", false},
                          {"number", true},
                          {"sum", true},
                          {"mean", true},
                          {"median", true},
                          {"smallest", true},
                          {"largest", true}},
                         {}};
    const auto add = [&grid](const char *name, const studies::Spread &spread) {
        grid.rows.push_back({name, fmt::format("{}", spread.number), number(spread.sum), number(spread.mean),
                             number(spread.median), number(spread.smallest), number(spread.largest)});
    };
    add("node mass [kg]", body.node_mass);
    add("spring stiffness [N/m]", body.stiffness);
    add("axial dashpot beta k [N s/m]", body.dashpot);
    add("mass damper alpha m [N s/m]", body.ground_damper);
    print_grid(grid, markdown);
}

void print_figures(const studies::BodyParameters &body, bool markdown) {
    results::Layout grid{{{"figure", false}, {"value", true}}, {}};
    const auto add = [&grid](const char *name, double value) { grid.rows.push_back({name, number(value)}); };
    add("mass [kg]", body.node_mass.sum);
    add("volume [L]", 1e3 * body.volume);
    add("damping alpha [1/s]", body.damping.alpha);
    add("damping beta [s]", body.damping.beta);
    add("first natural frequency [Hz]", body.frequency(0));
    add("largest angular frequency [rad/s]", body.largest_angular_frequency);
    add("critical time step of undamped Runge-Kutta 4 [s]", body.critical_time_step);
    print_grid(grid, markdown);
}

void print_claims(const studies::BodyParameters &body, bool markdown) {
    fmt::print("Beside Table 1 of Jurnal Teknologi 75, 10.11113/jt.v75.5068, {} tumours:\n{}",
               body.tumour_volume > 0.0 ? "with" : "without", markdown ? "\n" : "");
    results::Layout grid{
        {{"printed", false}, {"as", false}, {"printed [SI]", true}, {"here [SI]", true}, {"ratio", true}}, {}};
    const auto claims = studies::compare_with_paper(body);
    for (const auto &claim : claims)
        for (const auto &reading : claim.readings)
            grid.rows.push_back(
                {fmt::format("{} {} {}", claim.quantity->name, claim.printed, claim.quantity->unit.name),
                 reading.meaning, number(reading.printed), number(reading.computed), number(reading.ratio())});
    print_grid(grid, markdown);
    for (const auto &claim : claims)
        fmt::print("{}{} {} {}: {}.\n", markdown ? "- " : "", claim.quantity->name, claim.printed,
                   claim.quantity->unit.name,
                   claim.objection.empty() ? "can be" : "does not follow. " + claim.objection);
    fmt::print("\n");
}

std::string printed_change(const studies::PrintedQuantity &quantity) {
    return change(quantity.without_tumours, quantity.with_tumours);
}

/// What the tumours do, everything else being equal.
void print_effect(const studies::BodyParameters &healthy, const studies::BodyParameters &body, bool markdown) {
    fmt::print(
        "Effect of the tumours: the same mesh with the parenchyma's material everywhere, and with the tumours\n{}",
        markdown ? "\n" : "");
    results::Layout grid{
        {{"figure", false}, {"without", true}, {"with", true}, {"change [%]", true}, {"paper [%]", true}}, {}};
    const auto add = [&grid](const std::string &name, double before, double after, const std::string &paper) {
        grid.rows.push_back({name, number(before), number(after), change(before, after), paper});
    };
    add("mass [kg]", healthy.node_mass.sum, body.node_mass.sum, printed_change(studies::printed_mass));
    add("sum of spring stiffnesses [N/m]", healthy.stiffness.sum, body.stiffness.sum,
        printed_change(studies::printed_stiffness));
    for (int mode = 0; mode < num_compared_modes; ++mode)
        add(fmt::format("frequency of mode {} [Hz]", mode + 1), healthy.frequency(mode), body.frequency(mode), "-");
    add("critical time step of undamped Runge-Kutta 4 [s]", healthy.critical_time_step, body.critical_time_step, "-");
    print_grid(grid, markdown);
}

int print_parameters(const ParametersOptions &options) {
    const auto law = studies::find_spring_law(options.law);
    const auto [problems, notes, left_out] =
        studies::read_constrained_problems(options.bodies, options.load_case, options.material);
    print_notes(notes);
    for (const auto &problem : problems) {
        const auto parameters = studies::body_parameters(problem, law, options.damping);
        fmt::print("{}{}, springs by {}, constrained as in {}\n\n", options.markdown ? "## " : "", problem.body->name,
                   law.name, problem.load_case.name);
        print_spreads(parameters, options.markdown);
        print_figures(parameters, options.markdown);
        print_claims(parameters, options.markdown);
        if (auto healthy = studies::without_tumours(*problem.body)) {
            const core::Problem other{std::make_shared<const core::Body>(std::move(*healthy)), problem.load_case};
            print_effect(studies::body_parameters(other, law, options.damping), parameters, options.markdown);
        }
    }
    return 0;
}

} // namespace

Command add_parameters(CLI::App &parent) {
    auto *command = parent.add_subcommand(
        "parameters", "Print masses, stiffnesses and damping of the springs of bodies, beside those of the seed paper");
    auto options = std::make_shared<ParametersOptions>();
    add_bodies(*command, options->bodies);
    command->add_option("--law", options->law, "A name as in 'livermark list spring-laws'")->capture_default_str();
    add_constraints(*command, options->load_case);
    add_materials(*command, options->material);
    command->add_option("--damping-ratio", options->damping.ratio, "Damping over critical damping")
        ->capture_default_str();
    command
        ->add_option("--damping", options->damping.kind,
                     "rayleigh (by mass and stiffness, with the ratio at two frequencies), or by the mass or the "
                     "stiffness alone (with the ratio at the first mode)")
        ->transform(one_of(std::map<std::string, studies::DampingKind>{{"mass", studies::DampingKind::mass},
                                                                       {"stiffness", studies::DampingKind::stiffness},
                                                                       {"rayleigh", studies::DampingKind::rayleigh}}))
        ->default_str("rayleigh");
    command
        ->add_option("--damping-frequencies", options->damping.frequencies,
                     "The two frequencies [Hz] of --damping rayleigh; by default those of the first and the "
                     "twentieth mode")
        ->expected(2);
    command->add_flag("--markdown", options->markdown, "Print the tables in Markdown");
    return [options] {
        options->bodies = with_images_meshed(options->bodies, "livermark parameters");
        return print_parameters(*options);
    };
}

} // namespace livermark::cli
