#pragma once

#include <filesystem>

#include "core/problem.hpp"
#include "core/support/toml_input.hpp"

namespace livermark::load_cases {

/// Brings the lengths of a load case to metres, by the 'unit' that it says, and takes the 'unit' out. Forces,
/// tractions, times and accelerations are in SI units whatever it says, and so are the lengths in these. The [[cut]]
/// stays as it is: meshes::cuts_of_file() reads it.
/// @param load_case  whose numbers, all of them, are ones that arithmetic can square
/// @throws support::InputError with file, line and remedy
void bring_to_metres(toml::table &load_case);

/// Turns the directions in a load case with a body, from LPS to the coordinates of its mesh: accelerations, all vectors
/// of conditions, the direction of a disc and the way that a tool or a ball slides. Points are places in the mesh and
/// stay. Nothing happens on a body in LPS, nor where the load case names none of the patches of BodyAxes.
/// @param load_case  the whole file; keeps the places of its lines
/// @throws NotOnBody where something has a direction and the axes of the body are in doubt, and where a disc is found
///         by a point of the mesh and a direction of the patient; support::InputError where a displacement is free
///         along an axis that is none of the mesh
void turn_directions(toml::table &load_case, const core::BodyAxes &axes);

/// Says at once what a load case lacks, where that is more than one thing: the conditions, a place or what happens
/// there in each of them, a condition that constrains, keys of its events. One thing alone is refused by who reads it.
/// @throws support::InputError
void refuse_missing_parts(const toml::table &load_case);

/// A load case that is a part of another file; see read_load_case() for what a table may hold.
/// @param file  gives the name of the load case, and the place in messages
/// @param table  gets its lengths in metres, see bring_to_metres()
/// @return without its text
/// @throws support::InputError as read_load_case()
core::LoadCase load_case_of_table(toml::table &table, const std::filesystem::path &file, const core::TetraMesh &mesh);

} // namespace livermark::load_cases
