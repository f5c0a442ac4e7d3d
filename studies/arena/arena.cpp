#include "studies/arena/arena.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "core/mesh/refinement.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "results/hdf5/references.hpp"
#include "results/records/arena.hpp"
#include "results/records/result.hpp"
#include "studies/arena/arena_run.hpp"
#include "studies/models/motion/moving_method.hpp"
#include "studies/run/run.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

namespace {

constexpr int mesh_as_it_is = 1, bisected = 2, cut_into_eight = 3;

std::set<std::array<int, 2>> longest_edges(const core::TetraMesh &mesh) {
    std::set<std::array<int, 2>> edges;
    for (const auto &nodes : mesh.tetrahedra) {
        std::array<int, 2> longest{};
        double length = 0.0;
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = a + 1; b < 4; ++b) {
                const std::array<int, 2> edge{std::min(nodes[a], nodes[b]), std::max(nodes[a], nodes[b])};
                const double here = (mesh.points[edge[0]] - mesh.points[edge[1]]).norm();
                if (here > length) {
                    length = here;
                    longest = edge;
                }
            }
        edges.insert(longest);
    }
    return edges;
}

/// Names of load_cases/moving/.
std::vector<std::string> moving_load_cases() {
    const auto folder = support::root_folder() / moving_load_cases_folder;
    std::error_code nobody_cares; // a tree of somebody's own has none
    return std::filesystem::is_directory(folder, nobody_cares) ? support::list_toml(folder)
                                                               : std::vector<std::string>{};
}

/// The model that motions under a tool are judged by, and the same on the mesh as it is.
constexpr const char *tool_reference_model = "fem_p2_neo_hookean_refined_at_rims";
constexpr const char *coarse_tool_reference_model = "fem_p2_neo_hookean";

std::filesystem::path path_of(const core::Problem &problem) {
    return results::reference_path(stored_references_folder(), problem, tool_reference_model);
}

core::ToolHistory whole_motion(const core::Problem &problem, int level, int steps_per_frame) {
    auto history = models::reference_motion(problem, level, steps_per_frame);
    const auto &motion = problem.load_case.tool.value();
    if (std::ssize(history.time) != motion.num_records())
        throw support::InputError(
            fmt::format("the reference finds no next step at t = {:.3g} s on the mesh that is refined {} times; "
                        "take a smaller depth or slide",
                        history.time.back() + motion.frame_interval, level));
    return history;
}

constexpr int coarse_steps_per_frame = 2;
constexpr double unknown_change = std::numeric_limits<double>::quiet_NaN();
const core::ToolErrors unknown_errors{
    .contact = unknown_change, .after = unknown_change, .force = unknown_change, .over_time = {}};

results::ToolReference solve_tool_reference(const core::Problem &problem, const ToolReferenceOptions &options,
                                            const std::function<void(const std::string &)> &starting) {
    const auto &motion = problem.load_case.tool.value();
    const auto solve = [&](int level, int steps_per_frame) {
        starting(fmt::format("{}, refined {} times, {} steps in a frame", problem.body->name, level, steps_per_frame));
        return whole_motion(problem, level, steps_per_frame);
    };
    const auto &mesh = problem.body->mesh;
    const auto on_mesh = solve(0, options.steps_per_frame);
    const auto half_steps = core::compare(mesh, motion, solve(0, options.steps_per_frame / 2), on_mesh);
    const auto coarser = options.level == 1 ? on_mesh : solve(options.level - 1, options.steps_per_frame);
    auto finest = solve(options.level, options.steps_per_frame);
    const auto last_refinement = core::compare(mesh, motion, coarser, finest);
    return {.model = tool_reference_model,
            .level = options.level,
            .steps_per_frame = options.steps_per_frame,
            .history = std::move(finest),
            .last_refinement = last_refinement,
            .half_steps = half_steps};
}

void store_tool_reference(const results::ToolReference &reference, const core::Problem &problem,
                          const std::string &command_line) {
    const auto path = path_of(problem);
    std::error_code nobody_cares; // writing says it
    std::filesystem::create_directories(path.parent_path(), nobody_cares);
    results::write_tool_reference(path, reference, problem, results::current_provenance(command_line));
}

std::vector<models::MovingMethod> chosen_moving_methods(const std::vector<std::string> &names) {
    auto methods = models::all_moving_methods();
    for (const auto &name : names)
        support::find_named(methods, name, "method");
    std::erase_if(methods, [&](const models::MovingMethod &method) {
        return names.empty() ? method.only_when_named : std::ranges::find(names, method.name) == names.end();
    });
    return methods;
}

/// Leaves out the methods that do not know a part of a problem.
/// @param knows  that part
/// @param lack   clause on them: "glued only"
/// @param remedy  clause on what to do where they were asked for
/// @throws support::InputError if one was asked for by name
void leave_out(std::vector<models::MovingMethod> &methods, bool models::MovingMethod::*knows,
               const std::vector<std::string> &asked_for, std::string_view lack, std::string_view remedy,
               std::vector<std::string> &notes) {
    std::vector<std::string> names;
    for (const auto &method : methods)
        if (!(method.*knows))
            names.push_back(method.name);
    if (names.empty())
        return;
    if (!asked_for.empty())
        throw support::InputError(fmt::format("{} {} {}; leave {} out, or {}", fmt::join(names, ", "),
                                              names.size() == 1 ? "is" : "are", lack, names.size() == 1 ? "it" : "them",
                                              remedy));
    notes.push_back(fmt::format("{}, so left out here: {}", lack, fmt::join(names, ", ")));
    std::erase_if(methods, [knows](const models::MovingMethod &method) { return !(method.*knows); });
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

bool moves_tool(const std::string &load_case) {
    const auto known = moving_load_cases();
    if (std::ranges::find(known, load_case) != known.end())
        return true;
    std::error_code nobody_cares; // reading says it
    return load_case.ends_with(".toml") && std::filesystem::exists(load_case, nobody_cares) &&
           load_cases::load_case_kind(load_case).is_for("arena");
}

ProblemSet read_arena_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                               const meshes::MaterialOverride &material) {
    const auto file = find_toml_files({load_case}, moving_load_cases_folder, "load case").front();
    return read_moving_problems(bodies, file.string(), material);
}

core::Problem on_arena_mesh(const core::Problem &problem, int mesh) {
    if (mesh == mesh_as_it_is)
        return problem;
    if (mesh == cut_into_eight)
        return core::refine(problem);
    auto parts = core::bisect(*problem.body, longest_edges(problem.body->mesh));
    auto load_case = core::on_parts(problem.load_case, parts);
    return {std::make_shared<const core::Body>(std::move(parts.body)), std::move(load_case)};
}

void refuse_single_components(const core::LoadCase &load_case) {
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.is_constrained(f) && load_case.value[f].array().isNaN().any())
            throw support::InputError(
                fmt::format("load case {}: '{}' leaves a component of the displacement free, and interactive methods "
                            "constrain whole nodes; give all three components, or choose another load case",
                            load_case.name, load_case.on(f)->place));
}

results::ToolReference coarse_tool_reference(const core::Problem &problem, const std::filesystem::path &path,
                                             const std::string &command_line,
                                             const std::function<void(const std::string &)> &starting) {
    if (auto known = results::read_tool_reference(path, problem, coarse_tool_reference_model))
        return *std::move(known);
    support::check_place(path);
    starting(
        fmt::format("{}: a coarse reference of {}, which takes minutes", problem.body->name, problem.load_case.name));
    results::ToolReference coarse{.model = coarse_tool_reference_model,
                                  .level = 0,
                                  .steps_per_frame = coarse_steps_per_frame,
                                  .history = whole_motion(problem, 0, coarse_steps_per_frame),
                                  .last_refinement = unknown_errors,
                                  .half_steps = unknown_errors};
    results::write_tool_reference(path, coarse, problem, results::current_provenance(command_line));
    return coarse;
}

std::optional<results::ToolReference> find_tool_reference(const core::Problem &problem) {
    return results::read_tool_reference(path_of(problem), problem, tool_reference_model);
}

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

Found<results::Arena> run_arena(const ArenaOptions &options, const std::string &command_line,
                                const ProgressReport &report) {
    auto methods = chosen_moving_methods(options.methods);
    auto [problems, notes, left_out] = read_arena_problems(options.bodies, options.load_case, options.material);
    if (options.tool == ArenaTool::touching) {
        leave_out(methods, &models::MovingMethod::knows_contact, options.methods, "glued only", "take --tool glued",
                  notes);
        for (auto &problem : problems)
            problem.load_case =
                load_cases::with_touching_ball(std::move(problem.load_case), problem.body->mesh, options.friction);
    }
    Found<results::Arena> done{{}, notes};
    Steps steps(static_cast<int>(problems.size() * methods.size() * options.meshes.size()), report);
    for (const auto &problem : problems) {
        const auto reference = find_tool_reference(problem);
        if (!reference && options.tool == ArenaTool::glued)
            throw support::InputError(
                fmt::format("no reference motion of {} under {} is stored for this mesh, material and "
                            "load case; 'livermark arena --solve-reference' makes one in minutes to "
                            "an hour, with the other options as they are",
                            problem.body->name, problem.load_case.name));
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
        done.records.push_back(std::move(arena));
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
