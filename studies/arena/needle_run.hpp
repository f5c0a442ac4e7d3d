#pragma once

#include <string>
#include <vector>

#include "core/problem.hpp"
#include "models/motion/moving_method.hpp"
#include "results/records/needle.hpp"

namespace livermark::studies {

/// A needle and a body on one of the meshes of an arena.
struct NeedleScene {
    const core::Problem &problem;
    const core::Needle &needle;
    models::NeedlePlan plan;
    const results::NeedleArena &arena;                  ///< with what the reference meets
    const std::vector<core::Vector3> &reference_places; ///< (K) displacement of the places at the plan [m]
};

/// The arena of a needle without runs: what the static needle meets at the depths of a plan.
/// @param reference  of the needle on finer meshes
/// @param coarser    the same on the mesh before; null if there is none
results::NeedleArena empty_needle_arena(const core::Needle &needle, const models::NeedlePlan &plan,
                                        const core::Insertion &reference, const core::Insertion *coarser);

/// A method with all budgets and settings on one mesh. What has no choice of its effort moves once, or twice where its
/// steps have to be halved.
std::vector<results::NeedleArenaRun> run_needle_budgets(const models::MovingMethod &method, const NeedleScene &scene,
                                                        const std::vector<double> &budgets);

} // namespace livermark::studies
