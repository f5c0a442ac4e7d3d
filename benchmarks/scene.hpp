#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::benchmarks {

/// Names of the bodies of benchmarks, the smallest first: liver_healthy and liver_tumours as they ship (20,182 and
/// 24,299 springs), and liver_refined_once and liver_refined_twice (154,700 and 1.21 million), liver_healthy with every
/// tetrahedron cut into eight once or twice.
std::span<const std::string> body_names();

/// Makes a body, in seconds. The order of nodes that comes out of a refinement is one that no mesh generator gives, so
/// refined bodies are put in reverse Cuthill-McKee order; the others keep that of their file.
/// @throws support::InputError if there is none of that name
std::shared_ptr<const core::Body> make_body(const std::string &name);

/// Number of times that the tetrahedra of a body were cut into eight.
/// @throws support::InputError if there is none of that name
int num_refinements(const std::string &name);

/// A body that every competitor moves: it is stretched by 1 % along x, constrained where ligaments and veins hold a
/// liver (patch `posterior`) as it then is, and let go from rest without loads or damping. Its energy stays what it is,
/// so it can be moved for as long as a timing takes.
struct Scene {
    core::Problem problem;                  ///< the body at rest, and where it is constrained
    core::SpringNetwork springs;            ///< of the first spring law
    msm::NodalConditions conditions;        ///< all three components of a node are constrained, or none
    std::vector<bool> is_constrained;       ///< (N)
    std::vector<core::Vector3> start;       ///< (N) positions at t = 0 [m]
    double largest_angular_frequency = 0.0; ///< of the springs, linearised at rest [rad/s]
};

/// @param body  of make_body()
/// @throws support::InputError if the body has no patch `posterior`
Scene make_scene(std::shared_ptr<const core::Body> body);

/// The same scene with springs that all have the mean stiffness, for solvers that know but one.
Scene with_mean_stiffness(Scene scene);

/// The longest stable step of the springs of a scene without damping [s].
/// @param integrator  one of msm/integrators/
double critical_time_step(const Scene &scene, const std::string &integrator);

} // namespace livermark::benchmarks
