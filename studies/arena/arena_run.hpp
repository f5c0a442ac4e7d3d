#pragma once

#include <functional>
#include <optional>

#include "core/problem.hpp"
#include "core/tool/tool_motion.hpp"
#include "models/tool_motion/moving_method.hpp"
#include "results/records/arena.hpp"

namespace livermark::studies {

/// A body on one of the meshes of an arena. Its first nodes are those of the reference.
struct ArenaScene {
    core::Problem problem;
    const core::TetraMesh *mesh_of_reference = nullptr;
    const core::ToolHistory *reference = nullptr; ///< null if there is none: errors are NaN then
    std::vector<double> reference_volume_change;  ///< (F) of the mesh of the reference; empty if there is none
};

/// Settings of methods that take explicit steps: the least number of them, and twice that.
inline constexpr const char *stable_setting = "stable", *half_steps_setting = "half steps";

/// What a method can do in a frame.
struct MeasuredEffort {
    models::Effort effort;
    double seconds = 0.0; ///< of a frame, about
    double spread = 0.0;  ///< by how much the times behind it differed, as a part of them
    /// Whether the frame ends earlier whatever the number is, because the method stops where nothing is left to do.
    bool stops_early = false;
};

/// The largest effort that fits into a budget, as measured on a body that is moved for it. Times are measured until two
/// rounds agree, or ten times.
/// @param frame   moves a body, of a method with a choice, on by a frame that is like others
/// @param budget  of one core, for a frame [s]
/// @return the least effort, and what it takes, where nothing fits; nothing where only one step of ten iterations fits:
///   in one step more of them do
std::optional<MeasuredEffort> largest_effort(const std::function<void(const models::Effort &)> &frame,
                                             models::Setting setting, double budget);

/// Frames for that in the middle of the way of a tool, again and again.
/// @param body, motion  kept by reference
std::function<void(const models::Effort &)> frames_on_the_way_in(models::MovingBody &body,
                                                                 const core::ToolMotion &motion);

/// The same in steps of half the length; an explicit method has one of the two numbers only.
models::Effort twice(const models::Effort &effort);

/// A run of the arena with what it was given.
/// @param seconds  of a frame: where it is above the budget, the run is too slow
template <class Run> Run within_budget(Run run, const char *setting, double budget, double seconds) {
    run.setting = setting;
    run.budget = budget;
    if (run.outcome == results::ArenaOutcome::ok && seconds > budget)
        run.outcome = results::ArenaOutcome::too_slow;
    return run;
}

/// So many iterations of one step in a frame, or so many steps of ten iterations or of one.
models::Effort effort_of(models::Setting setting, int number);

/// The size of the force on a tool when its slide begins [N].
/// @param force  (K) at the records of the motion
double pressed_force(const core::ToolMotion &motion, const std::vector<core::Vector3> &force);

/// Moves a method through the whole motion and judges it.
results::ArenaRun run_method(const models::MovingMethod &method, const ArenaScene &scene, const models::Effort &effort);

/// (F) change of volume at each field, of the mesh whose nodes they are.
std::vector<double> volume_changes(const core::TetraMesh &mesh, const core::ToolHistory &history);

/// Volumes and inverted tetrahedra of a motion of the nodes of the reference.
void judge_shape(results::ArenaRun &run, const core::TetraMesh &mesh, const core::ToolHistory &history,
                 const core::ToolHistory &reference);

} // namespace livermark::studies
