#pragma once

#include "core/load_case.hpp"

namespace livermark::load_cases {

/// A load case in which a ball moves as its tool does: it touches the place that the tool has hold of otherwise, and
/// that is free. The ball has the radius that the [tool] says, comes the way that the place is pushed, through the
/// centroid of the place (weighted with how far it is pushed), and begins where it just touches the body at rest.
/// @param load_case  with a tool, as it was read on the mesh
/// @param friction   Coulomb's coefficient, >= 0
/// @throws support::InputError if the [tool] has no radius, or if the place is pushed nowhere
core::LoadCase with_touching_ball(core::LoadCase load_case, const core::TetraMesh &mesh, double friction);

} // namespace livermark::load_cases
