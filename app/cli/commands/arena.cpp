#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "app/cli/commands.hpp"
#include "app/cli/image_bodies.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "results/records/arena.hpp"
#include "results/records/needle.hpp"
#include "studies/arena/arena.hpp"
#include "studies/study.hpp"

namespace livermark::cli {

namespace {

struct ArenaCommand {
    std::vector<double> budgets{1.0, 4.0, 1000.0 / 60.0}; ///< [ms]
    studies::ToolReferenceOptions reference;
    studies::NeedleArenaOptions needle;
    bool has_load_case = false, has_meshes = false, has_needle_options = false;
    bool solve_reference = false, details = false, markdown = false;
};

std::string in_percent(double value) {
    return fmt::format("{:.2f} %", 100.0 * value);
}

void print_change(const char *what, const core::ToolErrors &errors) {
    fmt::print("  {} changes displacements in contact by {}, forces by {}, displacements after it by {}\n", what,
               in_percent(errors.contact), in_percent(errors.force), in_percent(errors.after));
}

int solve_references(const ArenaCommand &command, const studies::ArenaOptions &options,
                     const std::string &command_line) {
    const auto solved = studies::solve_arena_references(options, command.reference, command_line, print_progress());
    for (const auto &reference : solved) {
        fmt::print("{}, refined {} times, {} steps in a frame\n", reference.model, reference.level,
                   reference.steps_per_frame);
        print_change("the last refinement", reference.last_refinement);
        print_change("half as many steps", reference.half_steps);
    }
    return 0;
}

void print_arena(const results::Arena &arena, const ArenaCommand &command) {
    const auto print = [&](const results::Layout &layout) { fmt::print("{}\n", table_text(layout, command.markdown)); };
    if (arena.reference.empty()) {
        fmt::print("{}: {}\n{}; no reference motion with contact is stored, so there are forces and no errors\n\n",
                   arena.body, arena.title, results::tool_of(arena));
        print(results::arena_forces(arena));
    } else {
        fmt::print(
            "{}: {}\n{}; within a budget of one core for a frame of {:.1f} ms; the last refinement of the reference "
            "changed it by {} in contact, forces by {}\n\n",
            arena.body, arena.title, results::tool_of(arena), 1e3 * arena.frame_interval,
            in_percent(arena.reference_errors.contact), in_percent(arena.reference_errors.force));
        if (command.details) {
            print(results::arena_table(arena));
            fmt::print("{}\n", results::arena_legend());
        }
        print(results::arena_overview(arena));
        fmt::print("{}", results::overview_legend());
    }
    if (!arena.series.empty())
        print(results::arena_series(arena));
    fmt::print("{}", results::calibration_note(arena));
}

int run_needles(const ArenaCommand &command, studies::ArenaOptions options, const std::string &command_line) {
    if (command.solve_reference || !options.iterations.empty())
        throw support::InputError("the reference of a needle is static and solved at once, and a needle has no series; "
                                  "leave --solve-reference and --iterations out");
    if (!command.has_load_case)
        options.load_case = "nick";
    if (!command.has_meshes)
        options.meshes = {1};
    const auto found = studies::run_needle_arena(options, command.needle, command_line, print_progress());
    print_notes(found.notes);
    for (const auto &file : found.records)
        for (const auto &study : file.needles) {
            const auto table = results::needle_arena_table(*study.arena);
            fmt::print("{}: {}\n{}\n{}\n", file.body, file.title, results::needle_arena_note(study),
                       table_text(table, command.markdown));
        }
    fmt::print(stderr, "Result files are in {}\n", options.output);
    return 0;
}

int run_command_of_arena(const ArenaCommand &command, studies::ArenaOptions options, const std::string &command_line) {
    if (options.tool == studies::ArenaTool::glued && options.friction > 0.0)
        throw support::InputError("a glued tool has no friction; add --tool touching, or leave --friction out");
    if (options.tool != studies::ArenaTool::needle && command.has_needle_options)
        throw support::InputError(
            "--needle, --speed, --rest and --reference-on-mesh are of a needle; add --tool needle, "
            "or leave them out");
    if (options.tool == studies::ArenaTool::needle && options.friction > 0.0)
        throw support::InputError("the friction of a needle is that of its load case; leave --friction out");
    std::ranges::sort(options.iterations);
    options.iterations.erase(std::unique(options.iterations.begin(), options.iterations.end()),
                             options.iterations.end());
    options.bodies = with_images_meshed(options.bodies, command_line);
    options.budgets.clear();
    for (const double budget : sorted_once(command.budgets))
        options.budgets.push_back(1e-3 * budget);
    if (options.tool == studies::ArenaTool::needle)
        return run_needles(command, std::move(options), command_line);
    if (command.solve_reference)
        return solve_references(command, options, command_line);
    const auto found = studies::run_arena(options, command_line, print_progress());
    print_notes(found.notes);
    for (const auto &arena : found.records)
        print_arena(arena, command);
    fmt::print(stderr, "Result files are in {}\n", options.output);
    return 0;
}

} // namespace

Command add_arena(CLI::App &parent, const std::string &command_line) {
    auto *command =
        parent.add_subcommand("arena", "Compare the motion of springs and interactive methods under a moving tool or "
                                       "a needle. Each method gets the same time for a frame (--budget), takes as many "
                                       "steps or iterations as fit, and is compared with the reference");
    auto options = std::make_shared<studies::ArenaOptions>();
    auto arena = std::make_shared<ArenaCommand>();
    options->bodies = {"liver_healthy"};
    add_bodies(*command, options->bodies, "by default liver_healthy");
    auto *load_case =
        command
            ->add_option("--load-case", options->load_case,
                         "A name as in 'livermark list moving-load-cases', or the path of one with a [tool]; with "
                         "--tool needle as in 'livermark list needle-load-cases', by default nick")
            ->capture_default_str();
    command->add_option("--method", options->methods,
                        "Names as in 'livermark list methods'; by default all but those that run only when named");
    command->add_option("--budget", arena->budgets, "Processor times of one core for a frame [ms]")
        ->check(CLI::Range(0.01, 1e5))
        ->capture_default_str();
    command
        ->add_option("--iterations", options->iterations,
                     "Numbers of iterations in a frame to move with as well, whatever time they take: of one step, and "
                     "as steps with ten or one each; explicit methods take their least number of steps, and twice that")
        ->check(CLI::Range(1, 20000));
    auto *meshes =
        command
            ->add_option(
                "--mesh", options->meshes,
                "1: as given; 2: with the longest edge of each tetrahedron bisected; 3: with each tetrahedron cut "
                "into eight; with --tool needle by default 1")
            ->check(CLI::Range(1, 3))
            ->capture_default_str();
    command
        ->add_option(
            "--tool", options->tool,
            "glued: fixed to the tissue; touching: a ball in contact without adhesion; needle: driven in slowly "
            "and drawn out, compared with the static needle in the reference")
        ->transform(one_of(std::map<std::string, studies::ArenaTool>{{"glued", studies::ArenaTool::glued},
                                                                     {"touching", studies::ArenaTool::touching},
                                                                     {"needle", studies::ArenaTool::needle}}))
        ->default_str("glued");
    std::vector<CLI::Option *> needle_options;
    needle_options.push_back(command->add_option(
        "--needle", arena->needle.needles, "With --tool needle: names of needles of the load case; by default all"));
    needle_options.push_back(command
                                 ->add_option_function<double>(
                                     "--speed", [arena](double speed) { arena->needle.speed = 1e-3 * speed; },
                                     "With --tool needle: of the hand [mm/s]")
                                 ->check(CLI::Range(0.1, 200.0))
                                 ->default_str("20"));
    needle_options.push_back(command->add_option("--rest", arena->needle.rest, "With --tool needle: at the target [s]")
                                 ->check(CLI::Range(0.0, 60.0))
                                 ->capture_default_str());
    needle_options.push_back(command->add_flag(
        "--reference-on-mesh", arena->needle.reference_on_mesh,
        "With --tool needle: compare with the reference on the mesh itself, quicker, with no error bar"));
    command->add_option("--friction", options->friction, "With --tool touching: Coulomb's coefficient of friction")
        ->check(CLI::Range(0.0, 10.0))
        ->capture_default_str();
    add_materials(*command, options->material);
    add_output(*command, options->output,
               "Folder for <body>/arena.h5, or <body>/arena_touching_<friction>.h5 where the tool touches, or "
               "<body>/needle_arena.<load case>.h5");
    command->add_flag("--details", arena->details, "Also print a row for every budget and setting");
    command->add_flag("--markdown", arena->markdown, "Print tables in Markdown");
    command->add_flag("--solve-reference", arena->solve_reference,
                      "Solve and store the reference motion instead: minutes to an hour for each body");
    command
        ->add_option("--level", arena->reference.level,
                     "With --solve-reference: number of refinements at the rims of constrained and loaded places")
        ->check(CLI::Range(1, 4))
        ->capture_default_str();
    command->add_option("--steps", arena->reference.steps_per_frame, "With --solve-reference: time steps in a frame")
        ->check(CLI::Range(2, 1000))
        ->capture_default_str();
    return [options, arena, command_line, load_case, meshes, needle_options] {
        arena->has_needle_options =
            std::ranges::any_of(needle_options, [](const CLI::Option *option) { return option->count() > 0; });
        arena->has_load_case = load_case->count() > 0;
        arena->has_meshes = meshes->count() > 0;
        return run_command_of_arena(*arena, *options, command_line);
    };
}

} // namespace livermark::cli
