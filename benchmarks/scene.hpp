#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::benchmarks {

/// What every competitor moves: a body that is stretched by 1 % along x, constrained at its back as it then is, and let
/// go from rest without loads or damping. Its energy stays what it is, so it can be moved for as long as a timing
/// takes.
struct Scene {
    core::Problem problem;                  ///< the body at rest, and where it is constrained
    core::SpringNetwork springs;            ///< of the first spring law
    msm::NodalConditions conditions;        ///< all three components of a node are constrained, or none
    std::vector<bool> is_constrained;       ///< (N)
    std::vector<core::Vector3> start;       ///< (N) positions at t = 0 [m]
    double largest_angular_frequency = 0.0; ///< of the springs, linearised at rest [rad/s]
};

/// @param body  of make_body()
Scene make_scene(std::shared_ptr<const core::Body> body);

/// The same scene with springs that all have the mean stiffness, for solvers that know but one.
Scene with_mean_stiffness(Scene scene);

/// The longest stable step of the springs of a scene without damping [s].
/// @param integrator  one of msm/integrators/
double critical_time_step(const Scene &scene, const std::string &integrator);

} // namespace livermark::benchmarks
