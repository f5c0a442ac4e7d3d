#include <fmt/format.h>
#include <memory>
#include <vector>

#include "app/cli/commands.hpp"
#include "app/cli/image_bodies.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/units.hpp"
#include "load_cases/experiments/needle_curves.hpp"
#include "results/records/cut.hpp"
#include "results/records/needle.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/cutting/cut_study.hpp"
#include "studies/needle/needle_study.hpp"

namespace livermark::cli {

namespace {

int print_needles(const studies::NeedleOptions &options, bool markdown, const std::string &command_line) {
    const auto done = studies::drive_needles(options, command_line, print_progress());
    print_notes(done.notes);
    for (const auto &file : done.records) {
        const auto table = results::needle_table(file);
        fmt::print("{}: {}\n{}{}\n", file.body, results::printable(file.title), table_text(table, markdown),
                   results::needle_note(file));
    }
    fmt::print(stderr, "Result files are in {}\n", options.output);
    return 0;
}

/// Words behind --measured, --data and --rate.
struct MeasuredChoice {
    std::string record, data; ///< a name, empty for all that are there; see experiments::data_folders()
    double rate = experiments::nominal_needle_rate; ///< of records over time [m/s]
};

/// The record that is named, or all that are there; the first where none is, so that it says where to get it.
std::vector<experiments::NeedleRecord> chosen_records(const MeasuredChoice &choice) {
    const auto all = experiments::all_needle_records();
    if (!choice.record.empty())
        return {support::find_named(all, choice.record, "record of a needle")};
    std::vector<experiments::NeedleRecord> records;
    for (const auto &record : all)
        if (experiments::is_there(record, choice.data))
            records.push_back(record);
    return records.empty() ? std::vector{all.front()} : records;
}

void print_beside_models(const results::MeasuredNeedle &measured, bool markdown) {
    const auto print = [&](const results::Layout &table) { fmt::print("{}\n", table_text(table, markdown)); };
    const auto &needle = measured.needle;
    fmt::print("Measured, {}: {}\n", measured.name, measured.source);
    for (const auto &sentence : measured.unknown)
        fmt::print("  not known: {}\n", sentence);
    fmt::print(
        "  taken: the way of '{}', {:.1f} mm; {:.2f} mm wide, forces over {:.2g} mm, toughness {:.3g} J/m^2; the "
        "surface gives way at {:.2f} N, as measured\n",
        results::printable(needle.name), core::millimetres * needle.depth(), core::millimetres * needle.diameter,
        core::millimetres * needle.spread, needle.toughness, needle.puncture_force);
    for (const auto &sentence : measured.changed)
        fmt::print("  changed: {}\n", sentence);
    fmt::print(
        "  fitted: one factor of Young's moduli, so that it does so at {:.1f} mm; friction, to what is behind\n\n",
        core::millimetres * measured.puncture_depth);
    print(results::fitted_needle_table(measured));
    print(results::measured_needle_table(measured));
}

int print_measured(const studies::NeedleOptions &options, const MeasuredChoice &choice, bool markdown) {
    refuse_no_folder(choice.data);
    std::vector<experiments::NeedleCurve> curves; // all are read before anything is solved
    for (const auto &record : chosen_records(choice))
        curves.push_back(experiments::read_needle_curve(record, choice.data, choice.rate));
    std::vector<results::MeasuredNeedle> done;
    for (const auto &curve : curves) {
        done.push_back(studies::compare_with_measured(options, curve, print_progress()));
        print_beside_models(done.back(), markdown);
    }
    fmt::print("The records themselves:\n\n{}\n", table_text(results::needle_records_table(done), markdown));
    return 0;
}

int print_cut(studies::CutStudyOptions options, bool markdown, const std::string &command_line) {
    options.body = with_image_meshed(options.body, command_line);
    const auto done = studies::let_blade_in(options, command_line, print_progress());
    print_notes(done.notes);
    const auto &file = done.file;
    fmt::print("{}: {}\n{} step by step:\n\n", file.body, results::printable(file.title), file.runs.front().model);
    for (const auto &table : {results::cut_table(file), results::cut_models_table(file)})
        fmt::print("{}\n", table_text(table, markdown));
    fmt::print("{}\n", results::cut_judge_note(file));
    if (!file.levels.empty()) {
        const auto table = results::cut_levels_table(file);
        fmt::print("{} in the end, on meshes that are finer and finer at the rim of the wound:\n\n{}\n{}\n",
                   file.runs.front().model, table_text(table, markdown), results::cut_levels_note(file));
    }
    if (const auto table = results::cut_steps_table(file); !table.rows.empty())
        fmt::print(
            "Longest stable step of springs, by symplectic Euler with nothing damped and nothing constrained:\n\n"
            "{}\n",
            table_text(table, markdown));
    if (!file.motions.empty()) {
        const auto table = results::cut_motions_table(file);
        fmt::print("Methods that move in frames of {:.1f} ms, {} for each step of the blade:\n\n{}\n",
                   1e3 * file.frame_interval, file.frames_per_step, table_text(table, markdown));
    }
    fmt::print("{}", results::cut_note(file));
    fmt::print(stderr, "The result file is in {}\n", options.output);
    return 0;
}

} // namespace

Command add_needle(CLI::App &parent, const std::string &command_line) {
    auto *command =
        parent.add_subcommand("needle", "Drive needles into bodies and draw them out, and print the displacement of "
                                        "the target and the force of the hand for each model, beside the reference");
    auto options = std::make_shared<studies::NeedleOptions>();
    auto choice = std::make_shared<MeasuredChoice>();
    auto markdown = std::make_shared<bool>(false);
    options->bodies = {"liver_tumours"};
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
    add_output(*command, options->output,
               "Folder for <body>/needle.<load case>.h5, in the large regime needle.<load case>.large.h5");
    command->add_flag("--markdown", *markdown, "Print the tables in Markdown");
    auto *is_measured =
        command
            ->add_option("--measured", choice->record,
                         "Instead: put the models beside a measured needle in bovine liver, depth_force or time_force, "
                         "or without a name beside each whose data are there, with the stiffness and the friction "
                         "fitted, on the first way of 'puncture' or of the load case that is named, in the first body; "
                         "no file is written")
            ->expected(0, 1);
    auto *data = add_data(*command, choice->data);
    auto *rate = command
                     ->add_option("--rate", choice->rate,
                                  "With --measured: the rate at which the needle of time_force goes in [m/s], which "
                                  "says how long the unit of its displacement is")
                     ->check(CLI::Range(1e-4, 0.1))
                     ->capture_default_str();
    return [=] {
        if (is_measured->count() == 0) {
            if (data->count() + rate->count() > 0)
                throw support::InputError("--data and --rate are of a measured needle; add --measured, or leave them "
                                          "out");
            return print_needles(*options, *markdown, command_line);
        }
        auto chosen = *options;
        if (chosen.regime == core::Regime::large)
            throw support::InputError("--measured fits a linear body to the measured curve, so that it is of the small "
                                      "regime; leave --regime large out");
        if (rate->count() > 0 && choice->record == "depth_force")
            throw support::InputError("--rate is of a record over time, and 'depth_force' has depths; leave it out, or "
                                      "name time_force");
        if (load_case->count() == 0)
            chosen.load_case = "puncture";
        return print_measured(chosen, *choice, *markdown);
    };
}

Command add_cut(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "cut", "Move a blade into a body under load, step by step, and print the opening of the wound, the released "
               "energy and the time of each step for each model, beside the reference");
    auto options = std::make_shared<studies::CutStudyOptions>();
    auto markdown = std::make_shared<bool>(false);
    auto budgets = std::make_shared<std::vector<double>>(std::vector{1.0, 4.0, 1000.0 / 60.0});
    add_body(*command, options->body);
    command
        ->add_option("--load-case", options->load_case,
                     "The load while the blade goes in: a name as in 'livermark list load-cases', or a path")
        ->capture_default_str();
    command
        ->add_option("--blade", options->blade,
                     "The quadrilateral that the edge of the blade sweeps, as twelve numbers [m]: four corners in "
                     "turn; the edge goes from the side 0-1 to the side 3-2")
        ->expected(12)
        ->required();
    command->add_option("--steps", options->num_steps, "Number of steps of the blade")->capture_default_str();
    command->add_option("--toughness", options->toughness, "Toughness of the tissue, energy over area [J/m^2]")
        ->capture_default_str();
    command
        ->add_option(
            "--regime", options->regime,
            "Which models are compared: small (reference: linear elasticity) or large (reference: hyperelasticity on "
            "each cut body; minutes); by default that of the load case")
        ->transform(a_regime());
    command
        ->add_option("--refine", options->num_refined,
                     "How often the reference is refined at the rim of the wound in the end, for its error bar; 0 for "
                     "none")
        ->capture_default_str();
    command->add_option(
        "--model", options->models,
        "Names as in 'livermark list models', beside the reference on the mesh; by default those of a run");
    command->add_option("--method", options->motion.methods,
                        "Names as in 'livermark list methods', or all, of methods that move while the blade goes in, "
                        "under a load case of the small regime; none by default");
    command->add_option("--budget", *budgets, "With --method: processor times of one core for a frame [ms]")
        ->check(CLI::Range(0.01, 1e5))
        ->capture_default_str();
    command->add_option("--frames", options->motion.frames_per_step, "With --method: frames for each step of the blade")
        ->capture_default_str();
    add_materials(*command, options->material);
    add_output(*command, options->output,
               "Folder for <body>/cut.<load case>.h5, or cut.<load case>.large.h5 with --regime large");
    command->add_flag("--markdown", *markdown, "Print the tables in Markdown");
    return [=] {
        options->motion.budgets.clear();
        for (const double budget : *budgets)
            options->motion.budgets.push_back(1e-3 * budget);
        return print_cut(*options, *markdown, command_line);
    };
}

} // namespace livermark::cli
