#include <fmt/format.h>
#include <memory>

#include "app/cli/commands/commands.hpp"
#include "app/cli/common_options.hpp"
#include "app/cli/progress.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/units.hpp"
#include "results/records/needle.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/needle/needle_study.hpp"

namespace livermark::cli {

namespace {

int print_needles(const studies::NeedleOptions &options, bool markdown, const std::string &command_line) {
    const auto done = studies::drive_needles(options, command_line, print_progress());
    print_notes(done.notes);
    for (const auto &file : done.of_body) {
        const auto table = results::needle_table(file);
        fmt::print("{}: {}\n{}{}\n", file.body, results::printable(file.title),
                   markdown ? results::to_markdown(table) : results::to_text(table), results::needle_note(file));
    }
    fmt::print(stderr, "Result files are in {}\n", options.output);
    return 0;
}

int print_measured(const studies::NeedleOptions &options, bool markdown) {
    const auto measured = studies::compare_with_measured(options, print_progress());
    const auto print = [&](const results::Layout &table) {
        fmt::print("{}\n", markdown ? results::to_markdown(table) : results::to_text(table));
    };
    const auto &needle = measured.needle;
    fmt::print("Measured: {}\n", measured.source);
    for (const auto &sentence : measured.unknown)
        fmt::print("  not known: {}\n", sentence);
    fmt::print(
        "  taken: the way of '{}', {:.1f} mm; {:.2f} mm wide, forces over {:g} mm, toughness {:g} J/m^2; the "
        "surface gives way at {:.2f} N, as measured\n"
        "  fitted: one factor of Young's moduli, so that it does so at {:.1f} mm; friction, to what is behind\n\n",
        results::printable(needle.name), core::millimetres * needle.depth(), core::millimetres * needle.diameter,
        core::millimetres * needle.spread, needle.toughness, needle.puncture_force,
        core::millimetres * measured.puncture_depth);
    print(results::fitted_needle_table(measured));
    print(results::measured_needle_table(measured));
    return 0;
}

} // namespace

Command add_needle(CLI::App &parent, const std::string &command_line) {
    auto *command =
        parent.add_subcommand("needle", "Drive needles into bodies and draw them out, and print the displacement of "
                                        "the target and the force of the hand for each model, beside the reference");
    auto options = std::make_shared<studies::NeedleOptions>();
    auto markdown = std::make_shared<bool>(false), is_measured = std::make_shared<bool>(false);
    options->bodies = {"liver_tumours"};
    options->output = (support::root_folder() / "results" / "runs").string();
    command->add_option("--body", options->bodies, "Names as in 'livermark list bodies', or paths")
        ->capture_default_str();
    auto *load_case =
        command
            ->add_option("--load-case", options->load_case,
                         "A name as in 'livermark list needle-load-cases', or the path of one with a [[needle]]")
            ->capture_default_str();
    command->add_option("--model", options->models, "Names as in 'livermark list models'; by default those of a run");
    command
        ->add_option(
            "--regime", options->regime,
            "small (linear in the forces; reference: linear elasticity) or large (springs and hyperelastic elements "
            "come to rest under the forces; reference: hyperelasticity; hours with a refined reference)")
        ->transform(a_regime())
        ->default_str("small");
    command
        ->add_option("--step", options->step,
                     "From record to record, at most [m]; by default that of the load case, in the large regime 0.002")
        ->check(CLI::Range(1e-5, 0.1));
    command->add_flag("--reference-on-mesh", options->reference_on_mesh,
                      "Compare with the reference on the mesh itself, not on meshes refined along the needle: quicker, "
                      "but without an error bar");
    add_materials(*command, options->material);
    command
        ->add_option("--output", options->output,
                     "Folder for <body>/needle.<load case>.h5, in the large regime needle.<load case>.large.h5")
        ->capture_default_str();
    command->add_flag("--markdown", *markdown, "Print the tables in Markdown");
    command->add_flag("--measured", *is_measured,
                      "Instead: put the models beside a measured needle in bovine liver, with the stiffness and the "
                      "friction fitted, on the first way of 'puncture' or of the load case that is named, in the first "
                      "body; no file is written");
    return [=] {
        if (!*is_measured)
            return print_needles(*options, *markdown, command_line);
        auto chosen = *options;
        if (chosen.regime == core::Regime::large)
            throw support::InputError("--measured fits a linear body to the measured curve, so that it is of the small "
                                      "regime; leave --regime large out");
        if (load_case->count() == 0)
            chosen.load_case = "puncture";
        return print_measured(chosen, *markdown);
    };
}

} // namespace livermark::cli
