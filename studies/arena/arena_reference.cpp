#include "studies/arena/arena_reference.hpp"

#include <fmt/format.h>
#include <limits>
#include <utility>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "results/hdf5/references.hpp"
#include "results/records/result.hpp"
#include "studies/models/motion/whole_motion.hpp"
#include "studies/run/solutions.hpp"

namespace livermark::studies {

namespace {

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

} // namespace

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

bool has_stored_tool_reference(const core::Problem &problem) {
    return results::read_tool_reference(path_of(problem), problem, tool_reference_model).has_value();
}

results::ToolReference stored_tool_reference(const core::Problem &problem) {
    auto stored = results::read_tool_reference(path_of(problem), problem, tool_reference_model);
    if (!stored)
        throw support::InputError(
            fmt::format("no reference motion of {} under {} is stored for this mesh, material and "
                        "load case; 'livermark arena --solve-reference' makes one in minutes to "
                        "an hour, with the other options as they are",
                        problem.body->name, problem.load_case.name));
    return *std::move(stored);
}

void store_tool_reference(const results::ToolReference &reference, const core::Problem &problem,
                          const std::string &command_line) {
    const auto path = path_of(problem);
    std::error_code nobody_cares; // writing says it
    std::filesystem::create_directories(path.parent_path(), nobody_cares);
    results::write_tool_reference(path, reference, problem, results::current_provenance(command_line));
}

} // namespace livermark::studies
