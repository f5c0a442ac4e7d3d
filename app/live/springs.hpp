#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/live/scene.hpp"
#include "core/problem.hpp"
#include "msm/cutting/cut_parts.hpp"
#include "msm/springs/springs.hpp"

/// The springs that may move.
namespace livermark::live {

/// Names that Settings::springs may have: those of msm::all_spring_laws(), then those of msm::all_coupled_springs()
/// that the fast kernels know.
const std::vector<std::string> &spring_names();

/// Whether their energy alone keeps tetrahedra from turning inside out.
bool keep_from_inverting(const std::string &springs);

using SpringsOfLaws = std::map<std::string, core::SpringNetwork, std::less<>>;

/// Springs, and what else the settings ask for. The stiffness that a law gives is Young's modulus times a number of the
/// mesh, so each law is asked once and its solution kept.
/// @param own   the body with its own materials; the settings say with which it moves
/// @param kept  springs of laws for the body with another Young's modulus: these do not depend on what was chosen
/// before
/// @throws support::InputError if there are no such springs
msm::MassSprings mass_springs(const core::Body &own, const Settings &settings, SpringsOfLaws &kept);

/// Source of the stiffness of these springs, for msm::CutParts; nothing of springs that are coupled.
std::optional<msm::SpringSource> spring_source(const core::Body &own, const Settings &settings);

/// The same with the material that the guard against inversion has everywhere: that of the largest region, with a
/// Poisson's ratio of at most 0.45. What is nearly incompressible keeps its volume without a guard that is as stiff,
/// and what is pressed would ask for half the step at 0.49.
core::Body with_material_of_guard(core::Body body);

} // namespace livermark::live
