#pragma once

#include "core/problem.hpp"
#include "support/toml_input.hpp"

namespace livermark::load_cases {

/// Turns the directions in a load case with a body, from LPS to the coordinates of its mesh: accelerations, all vectors
/// of conditions, the direction of a disc and the way that a tool or a ball slides. Points are places in the mesh and
/// stay. Nothing happens on a body in LPS, nor where the load case names none of the patches of BodyAxes.
/// @param load_case  the whole file; keeps the places of its lines
/// @throws NotOnBody where something has a direction and the axes of the body are in doubt, and where a disc is found
/// by
///         a point of the mesh and a direction of the patient; support::InputError where a displacement is free along
///         an axis that is none of the mesh
void turn_directions(toml::table &load_case, const core::BodyAxes &axes);

} // namespace livermark::load_cases
