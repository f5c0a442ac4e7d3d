#pragma once

#include <string>

#include "benchmarks/competitor.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::benchmarks {

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

/// Evaluations of all forces in a step of an explicit integrator of msm/.
int forces_per_step(const std::string &integrator);

/// A method of explicit steps of the springs of a scene, which are compared with the oracle.
Method spring_method(const std::string &integrator, std::function<Run(const Scene &, double)> make, double tolerance);

} // namespace livermark::benchmarks
