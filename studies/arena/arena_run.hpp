#pragma once

#include <vector>

#include "core/problem.hpp"
#include "core/tool/tool_motion.hpp"
#include "results/records/arena.hpp"
#include "studies/arena/frame_loop.hpp"

namespace livermark::studies {

/// A body on one of the meshes of an arena. Its first nodes are those of the reference.
struct ArenaScene {
    core::Problem problem;
    const core::TetraMesh *mesh_of_reference = nullptr;
    const core::ToolHistory *reference = nullptr; ///< null if there is none: errors are NaN then
    std::vector<double> reference_volume_change;  ///< (F) of the mesh of the reference; empty if there is none
};

/// The size of the force on a tool when its slide begins [N].
/// @param force  (K) at the records of the motion
double pressed_force(const core::ToolMotion &motion, const std::vector<core::Vector3> &force);

/// A method through the whole motion, judged, with all budgets and settings on one mesh. What has no choice of its
/// effort moves once, or twice where its steps have to be halved.
std::vector<results::ArenaRun> run_budgets(const models::MovingMethod &method, const ArenaScene &scene,
                                           const std::vector<double> &budgets);

/// The same with given numbers of iterations.
std::vector<results::ArenaRun> run_series(const models::MovingMethod &method, const ArenaScene &scene,
                                          const std::vector<int> &iterations);

/// (F) change of volume at each field, of the mesh whose nodes they are.
std::vector<double> volume_changes(const core::TetraMesh &mesh, const core::ToolHistory &history);

/// Volumes and inverted tetrahedra of a motion of the nodes of the reference.
void judge_shape(results::ArenaRun &run, const core::TetraMesh &mesh, const core::ToolHistory &history,
                 const core::ToolHistory &reference);

} // namespace livermark::studies
