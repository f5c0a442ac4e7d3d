#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::benchmarks {

/// The main function of a benchmark program, with all flags of Google Benchmark: says which machine, compiler and
/// commit were at work, and runs what is asked for. What --benchmark_format asks for is all that goes to standard
/// output. With --hdf5=FILE it also writes the timing file of results/schema.md.
/// @param register_all  registers the benchmarks
/// @return exit status: 0, 1 if one of them refused a solution or could not be made, 2 for wrong arguments
int run_program(int argc, char **argv, const std::function<void()> &register_all);

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

/// A scene on its way.
struct Run {
    std::function<void()> step;                            ///< moves on by one step
    std::function<std::vector<core::Vector3>()> positions; ///< (N) [m], in the numbering of the mesh
    /// Residual of the equations that the next step solves, relative to their largest term; empty where it solves none.
    std::function<double()> residual{};
    std::size_t bytes = 0; ///< of memory that a step reads or writes; 0 where nobody knows
    int held_steps = 0;    ///< steps from one move of the branches of relaxing springs to the next; 0 of elastic ones
};

/// Something that moves a scene in steps.
struct Method {
    std::string integrator;  ///< as in msm/integrators/, or the usual word for another rule
    int forces_per_step = 1; ///< evaluations of all forces
    int num_threads = 1;     ///< of several, wall clock time counts, else processor time
    /// The longest step that is stable [s]; infinity where every one is.
    std::function<double(const Scene &)> critical_time_step;
    /// Puts a scene at its start.
    /// @param time_step  h [s], > 0
    std::function<Run(const Scene &, double time_step)> make;
    /// Looks whether the steps of a run at its start are right, before anything is timed.
    /// @return what is wrong, empty if nothing is
    std::function<std::string(const Scene &, double time_step, Run &)> check;
    /// Bodies that are refined more often take too much time or memory.
    int max_refinements = std::numeric_limits<int>::max();
};

/// One that takes part among the models for the shortest step: a kernel of ours, or what people would pick instead.
/// Peers have one file each in peers/, named as the peer.
struct Competitor {
    std::string name{};  ///< the file stem; set by the table
    std::string summary; ///< one line
    std::string source;  ///< who made it
    std::vector<Method> methods;
};

/// Every peer of peers/, in alphabetical order.
std::span<const Competitor> all_peers();

/// Steps that are compared before a timing: more than one, so that velocities count.
inline constexpr int num_checked_steps = 3;

/// Whether the first steps of a run are those of the slow, obvious kernels of msm/.
/// @param body        of the scene
/// @param integrator  one of msm/integrators/
/// @param tolerance   largest distance of a node from where it should be, as a part of the largest motion
/// @return what is wrong, empty if nothing is
std::string differs_from_oracle(const Scene &scene, const msm::ElasticBody &body, const std::string &integrator,
                                double time_step, Run &run, double tolerance);

/// The same for steps that are known some other way.
/// @param wanted  shape (N) [m], where the nodes should be
std::string differs_from(const std::vector<core::Vector3> &wanted, const Scene &scene, const Run &run,
                         double tolerance);

/// Whether a run has gone further than the size of the body, or nowhere: what it then computes need not take the time
/// that it takes in use.
/// @return what is wrong, empty if nothing is
std::string has_left(const Scene &scene, const Run &run);

/// A method of explicit steps of the springs of a scene, which are compared with the oracle.
Method spring_method(const std::string &integrator, std::function<Run(const Scene &, double)> make, double tolerance);

} // namespace livermark::benchmarks
