#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "live/scene.hpp"
#include "msm/springs_with_volume.hpp"

/// The springs that may move.
namespace livermark::live {

/// Names that Settings::springs may have: those of msm::all_spring_laws(), then nodal_springs (msm/nodal_springs.hpp)
/// and nodal_<energy> of each energy that the fast kernels know (msm/hyperelastic_springs.hpp).
const std::vector<std::string> &spring_names();

/// Whether their energy alone keeps tetrahedra from turning inside out.
bool keep_from_inverting(const std::string &springs);

using SpringsOfLaws = std::map<std::string, core::SpringNetwork, std::less<>>;

/// Springs, and what else the settings ask for. The stiffness that a law gives is Young's modulus times a number of the
/// mesh, so each law is asked once and its solution kept.
/// @param body  with the material that the settings ask for
/// @param kept  springs of laws for the body with another Young's modulus, all regions in the same ratio
/// @throws support::InputError if there are no such springs
msm::MassSprings mass_springs(const core::Body &body, const Settings &settings, SpringsOfLaws &kept);

/// The same with the largest region's material everywhere.
core::Body of_one_material(core::Body body);

} // namespace livermark::live
