#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/live/scene.hpp"
#include "core/problem.hpp"
#include "msm/cutting/cut_parts.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "msm/springs/springs.hpp"

/// Material, springs and steps of a body, whole or cut, as one who handles it may choose them.
namespace livermark::live {

/// Names that Settings::springs may have: those of msm::all_spring_laws(), then those of msm::all_coupled_springs()
/// that the fast kernels know.
const std::vector<std::string> &spring_names();

/// Whether their energy alone keeps tetrahedra from turning inside out.
bool keep_from_inverting(const std::string &springs);

using SpringsOfLaws = std::map<std::string, core::SpringNetwork, std::less<>>;

/// Springs with the capsule, the vessels and the map of stiffness of the body, and what else the settings ask for. The
/// stiffness that a law gives is Young's modulus times a number of the
/// mesh, so each law is asked once and its solution kept.
/// @param own   the body with its own materials; the settings say with which it moves
/// @param kept  springs of laws for the body with another Young's modulus: these do not depend on what was chosen
/// before
/// @throws support::InputError if there are no such springs
msm::MassSprings mass_springs(const core::Body &own, const Settings &settings, SpringsOfLaws &kept);

/// Source of the stiffness of these springs, for msm::CutParts; nothing of springs that are coupled.
std::optional<msm::SpringSource> spring_source(const core::Body &own, const Settings &settings);

/// The same with the material that the guard against inversion has everywhere: that of the largest region, whatever a
/// map of stiffness says, with a Poisson's ratio of at most 0.45. What is nearly incompressible keeps its volume
/// without a guard that is as stiff, and what is pressed would ask for half the step at 0.49.
core::Body with_material_of_guard(core::Body body);

/// Index of the region with the largest volume, the first of several.
int largest_region(const core::TetraMesh &mesh);

/// The same body of another material. All keep their density, and capsule, vessels and map of stiffness stay as they
/// are.
/// @param young_modulus  of the largest region [Pa]; the others keep the ratio of theirs to it
/// @param poisson_ratio  of all regions
core::Body with_material(core::Body body, double young_modulus, double poisson_ratio);

/// @throws support::InputError with what is wrong and the remedy
void check_body(const core::Body &body, const std::vector<bool> &is_constrained);
/// @param mesh  that has been checked
void check_foundation(const core::Foundation &foundation, const core::TetraMesh &mesh,
                      const std::vector<bool> &is_constrained);
void check_settings(const Settings &settings);
void check_tool(const Tool &tool, const Surface &surface);

/// Nodes of boundary triangles that are constrained, shape (N).
std::vector<bool> constrained_nodes(const core::TetraMesh &mesh, const std::vector<bool> &is_constrained);

/// Conditions without loads, under which these nodes do not move.
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

struct FittedRest {
    msm::PartOfBody part; ///< at rest
    msm::MassSprings springs;
    Stepping stepping; ///< in numbers of the part
};

/// Springs below a body, see msm::foundation_springs(); null where it stands on none.
using FoundationTerm = std::shared_ptr<const msm::ElasticTerm>;

/// @param body        whole, of the chosen material
/// @param foundation  of that
/// @param is_gone     shape (M)
/// @param conditions  of the nodes of the whole body
/// @throws support::InputError if the time step is too long for what is left
FittedRest fit_rest(const core::Body &body, const FoundationTerm &foundation, const std::vector<char> &is_gone,
                    const msm::NodalConditions &conditions, const Settings &settings);

/// The same steps of a body that has been parted since, of which nodes keep their numbers.
FittedRest refit_rest(const FittedRest &before, const core::Body &body, const FoundationTerm &foundation,
                      const std::vector<char> &is_gone, const msm::NodalConditions &conditions,
                      const Settings &settings);

/// Scaling of its masses in numbers of the whole body.
msm::MassScaling scaling_of_whole(const FittedRest &rest);

/// watched_volumes() in numbers of the whole body of so many tetrahedra; none of what is gone.
std::vector<double> watched_of_whole(const FittedRest &rest, const Stepping &stepping, std::size_t num_tetrahedra);

/// The critical time step of what is around a wound, with all else constrained, of symplectic Euler at rest [s]:
/// infinity if nothing there moves. Steps below this and below the critical one before the cut are stable after it.
/// Nodes whose masses are scaled count as constrained: they are heavy. Springs of laws that look at the whole body are
/// those of the part around the wound.
/// @param body        whole, of the chosen material
/// @param foundation  of that
/// @param is_gone     shape (M), with the new cut
/// @param gone        tetrahedra that the new cut takes
/// @param scaling     of the masses that stay scaled, in numbers of the whole body
double critical_step_around(const core::Body &body, const FoundationTerm &foundation, const std::vector<char> &is_gone,
                            std::span<const int> gone, msm::NodalConditions conditions, const msm::MassScaling &scaling,
                            const Settings &settings);

struct Scene::Prepared {
    core::Body body; ///< of the chosen material, whole
    msm::MassSprings parts;
    Settings settings;
    Stepping stepping; ///< of the whole body, or of the rest in its numbers
    /// Remains that cuts had left when this was chosen; null if nothing had been cut.
    std::shared_ptr<const FittedRest> rest;
    std::size_t num_cuts = 0; ///< that had been made by then
};

struct Scene::Unparted {
    core::Body body;
    std::vector<int> original_node;
    std::vector<bool> is_constrained;
    FoundationTerm foundation;
    std::shared_ptr<const Prepared> prepared;
};

/// Steps that are divided after something was pressed: to change their length at each oscillation would add energy.
inline constexpr int num_divided = 16;

/// Number of parts into which a step has to be divided so that none is longer.
int num_parts_of(double time_step, double longest);

} // namespace livermark::live
