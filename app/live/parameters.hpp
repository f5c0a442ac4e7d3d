#pragma once

#include <vector>

#include "app/live/scene.hpp"
#include "core/problem.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "msm/springs/springs.hpp"

/// The material of a body as one who handles it may choose it.
namespace livermark::live {

/// Index of the region with the largest volume, the first of several.
int largest_region(const core::TetraMesh &mesh);

/// The same body of another material. All keep their density.
/// @param young_modulus  of the largest region [Pa]; the others keep the ratio of theirs to it
/// @param poisson_ratio  of all regions
core::Body with_material(core::Body body, double young_modulus, double poisson_ratio);

/// From what somebody may choose to what moves, and whether it may be chosen.

/// @throws support::InputError with what is wrong and the remedy
void check_body(const core::Body &body, const std::vector<bool> &is_constrained);
void check_settings(const Settings &settings);
void check_tool(const Tool &tool, const Surface &surface);

/// Nodes of boundary triangles that are constrained, shape (N).
std::vector<bool> constrained_nodes(const core::TetraMesh &mesh, const std::vector<bool> &is_constrained);

/// No loads, and these nodes do not move.
msm::NodalConditions constrained_conditions(const std::vector<bool> &is_constrained);

/// The steps that a body takes, and with which masses.
struct Stepping {
    Chosen chosen;
    msm::MassScaling scaling; ///< without parts where masses are as they are
    Chosen unscaled;          ///< the longest steps with masses as they are
};

/// The steps that a body may take, and does. One bears a pressed body, whose tetrahedra have lost so much volume that
/// their guards make them stiffer, and while one is pressed every step is divided into parts that are no longer than
/// that. The longest step is what the body bears otherwise. The masses of stiff parts are scaled where that makes the
/// longest step so much longer that it pays, and where a step is asked for that the body does not bear as it is.
Stepping chosen_steps(const core::Body &body, const msm::MassSprings &parts, const msm::NodalConditions &conditions,
                      const Settings &settings);

/// The critical time step of symplectic Euler with the damping of the settings [s].
/// @param highest  frequency [rad/s], > 0
double critical_step(double highest, const Settings &settings);

/// Volumes of tetrahedra below which steps have to be divided: 7/10 of those at rest, where the guard could make them
/// too stiff for whole ones, and 0 for the others. How stiff is told by Gershgorin's bounds around nodes of the pressed
/// body, of which the largest is set to what the frequency of that body is. A node of a part whose masses are scaled
/// counts with its part's.
/// @return shape (M) [m^3]; empty if none has to be watched
std::vector<double> watched_volumes(const core::Body &body, const msm::MassSprings &parts,
                                    const msm::NodalConditions &conditions, const Stepping &stepping);

/// Mean length of the edges [m].
double mean_edge(const core::TetraMesh &mesh);

/// Largest speed of all nodes [m/s].
/// @param velocity  shape (3 N) [m/s]
double largest_speed(const Eigen::VectorXd &velocity);

/// Smallest volume of all tetrahedra, as a part of what it is at rest.
double smallest_volume_ratio(const core::TetraMesh &mesh, const std::vector<core::Vector3> &displacement);

/// Way by which a body yields under nodal forces, sum of f_i . u_i / |sum of f_i| [m]; 0 without a force.
double indentation(const Load &load, const std::vector<core::Vector3> &displacement);

} // namespace livermark::live
