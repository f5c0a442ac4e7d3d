#pragma once

#include <stdexcept>
#include <vector>

#include "interactive/simulation.hpp"
#include "models/tool_motion/moving_method.hpp"
#include "msm/kernels/fast_steps.hpp"

/// What all bodies that move frame by frame have in common, whatever acts on them.
namespace livermark::models {

/// (N) of the nodes of the mesh [m]
inline std::vector<core::Vector3> displacement_of(const livermark::interactive::Simulation &simulation) {
    auto result = simulation.scene().body->mesh.points;
    for (std::size_t i = 0; i < result.size(); ++i)
        result[i] = simulation.positions().col(static_cast<Eigen::Index>(i)) - result[i];
    return result;
}

inline FrameCost frame_cost(const livermark::interactive::Simulation &simulation, const Effort &effort) {
    const auto cost = simulation.cost(effort.iterations);
    return {cost.element_passes * effort.steps, cost.bytes_per_element};
}

inline FrameCost frame_cost(const livermark::msm::FastSteps &steps, const core::Body &body, const Effort &effort) {
    return {static_cast<double>(effort.steps),
            static_cast<double>(steps.working_set()) / static_cast<double>(body.mesh.tetrahedra.size())};
}

/// Steps of symplectic Euler on vector units, forces in single precision.
/// @param mass_damping  alpha [1/s]
/// @param time_step     h [s], > 0
/// @throws std::logic_error if the fast kernels do not know the springs
inline livermark::msm::FastSteps frame_steps(const livermark::msm::ElasticBody &springs, const core::Body &body,
                                             const livermark::msm::NodalConditions &conditions, double mass_damping,
                                             double time_step, const livermark::msm::FastStepOptions &options = {}) {
    auto steps =
        livermark::msm::FastSteps::prepare(springs, body.mesh.points, conditions, {.alpha = mass_damping, .beta = 0.0},
                                           "symplectic_euler", time_step, options);
    if (!steps)
        throw std::logic_error("the fast kernels do not know these springs");
    return *std::move(steps);
}

} // namespace livermark::models
