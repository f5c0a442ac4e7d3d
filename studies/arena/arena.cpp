#include "studies/arena/arena.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <utility>

#include "core/support/input_error.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "results/provenance.hpp"
#include "results/records/arena.hpp"
#include "studies/arena/arena_problems.hpp"
#include "studies/arena/arena_run.hpp"
#include "studies/files.hpp"
#include "studies/models/motion/moving_method.hpp"
#include "studies/run/problems.hpp"

namespace livermark::studies {

namespace {

std::vector<models::MovingMethod> chosen_moving_methods(const std::vector<std::string> &names) {
    auto methods = models::all_moving_methods();
    for (const auto &name : names)
        support::find_named(methods, name, "method");
    std::erase_if(methods, [&](const models::MovingMethod &method) {
        return names.empty() ? method.only_when_named : std::ranges::find(names, method.name) == names.end();
    });
    return methods;
}

/// Methods that know no contact.
/// @throws support::InputError if one was asked for by name
void leave_out_glued(std::vector<models::MovingMethod> &methods, const std::vector<std::string> &asked_for,
                     std::vector<std::string> &notes) {
    std::vector<std::string> glued;
    for (const auto &method : methods)
        if (!method.knows_contact)
            glued.push_back(method.name);
    if (glued.empty())
        return;
    if (!asked_for.empty())
        throw support::InputError(fmt::format("{} {} glued only; leave {} out, or take --tool glued",
                                              fmt::join(glued, ", "), glued.size() == 1 ? "is" : "are",
                                              glued.size() == 1 ? "it" : "them"));
    notes.push_back(fmt::format("glued only, so left out where the tool touches: {}", fmt::join(glued, ", ")));
    std::erase_if(methods, [](const models::MovingMethod &method) { return !method.knows_contact; });
}

/// One of each tool, so that none takes the place of another.
std::string arena_file_of(const ArenaOptions &options) {
    return options.tool == ArenaTool::glued ? "arena.h5" : fmt::format("arena_touching_{:g}.h5", options.friction);
}

results::ArenaMethod texts_of(const models::MovingMethod &method) {
    return {.name = method.name,
            .source = method.source,
            .implementation = method.implementation,
            .converges_to = method.converges_to,
            .objection = method.objection};
}

} // namespace

results::Arena empty_arena(const core::Problem &problem, const results::ToolReference *reference,
                           const std::string &command_line) {
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    const auto &load_case = problem.load_case;
    results::Arena arena{.provenance = results::current_provenance(command_line),
                         .body = problem.body->name,
                         .load_case = load_case.name,
                         .title = load_case.title,
                         .reference = reference ? reference->model : "",
                         .frame_interval = load_case.tool.value().frame_interval,
                         .time = core::record_times(*load_case.tool),
                         .reference_force = {},
                         .reference_errors = {.contact = unknown, .after = unknown, .force = unknown, .over_time = {}},
                         .runs = {},
                         .series = {},
                         .methods = {}};
    if (load_case.touching) {
        arena.tool = results::touching_tool;
        arena.friction = load_case.touching->friction;
        arena.ball_radius = load_case.touching->shape.radius;
        arena.face = load_case.touching->shape.face;
        arena.plate_size = load_case.touching->shape.size;
    }
    arena.reference_force.assign(arena.time.size(), core::Vector3::Constant(unknown));
    if (reference) {
        arena.time = reference->history.time;
        arena.reference_force = reference->history.force;
        arena.reference_errors = reference->last_refinement;
        arena.reference_pressed_force = pressed_force(*load_case.tool, reference->history.force);
    }
    return arena;
}

ArenaResults run_arena(const ArenaOptions &options, const std::string &command_line, const ProgressReport &report) {
    auto methods = chosen_moving_methods(options.methods);
    auto [problems, notes, left_out] = read_arena_problems(options.bodies, options.load_case, options.material);
    if (options.tool == ArenaTool::touching) {
        leave_out_glued(methods, options.methods, notes);
        for (auto &problem : problems)
            problem.load_case =
                load_cases::with_touching_ball(std::move(problem.load_case), problem.body->mesh, options.friction);
    }
    ArenaResults done{{}, notes};
    Steps steps(static_cast<int>(problems.size() * methods.size() * options.meshes.size()), report);
    for (const auto &problem : problems) {
        std::optional<results::ToolReference> reference;
        if (options.tool == ArenaTool::glued || has_stored_tool_reference(problem))
            reference = stored_tool_reference(problem);
        const OutputFile file(options.output, problem, arena_file_of(options));
        auto arena = empty_arena(problem, reference ? &*reference : nullptr, command_line);
        std::ranges::transform(methods, std::back_inserter(arena.methods), texts_of);
        const auto changes = reference ? volume_changes(problem.body->mesh, reference->history) : std::vector<double>{};
        for (const int mesh : options.meshes) {
            const ArenaScene scene{on_arena_mesh(problem, mesh), &problem.body->mesh,
                                   reference ? &reference->history : nullptr, changes};
            for (const auto &method : methods) {
                steps.next(fmt::format("{} / {} tetrahedra / {}", problem.body->name,
                                       scene.problem.body->mesh.tetrahedra.size(), method.name));
                std::ranges::move(run_budgets(method, scene, options.budgets), std::back_inserter(arena.runs));
                std::ranges::move(run_series(method, scene, options.iterations), std::back_inserter(arena.series));
            }
        }
        results::write_arena(file.path(), arena);
        done.of_body.push_back(std::move(arena));
    }
    return done;
}

std::vector<results::ToolReference> solve_arena_references(const ArenaOptions &options,
                                                           const ToolReferenceOptions &reference,
                                                           const std::string &command_line,
                                                           const ProgressReport &report) {
    if (options.tool == ArenaTool::touching)
        throw support::InputError("the reference motion knows no contact; leave --solve-reference or --tool touching "
                                  "out");
    const auto [problems, notes, left_out] = read_arena_problems(options.bodies, options.load_case, options.material);
    constexpr int motions = 4;
    Steps steps(motions * static_cast<int>(problems.size()), report);
    std::vector<results::ToolReference> solved;
    for (const auto &problem : problems) {
        solved.push_back(
            solve_tool_reference(problem, reference, [&](const std::string &about) { steps.next(about); }));
        store_tool_reference(solved.back(), problem, command_line);
    }
    return solved;
}

} // namespace livermark::studies
