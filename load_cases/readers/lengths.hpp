#pragma once

#include "support/toml_input.hpp"

namespace livermark::load_cases {

/// Brings the lengths of a load case to metres, by the 'unit' that it says, and takes the 'unit' out. Forces,
/// tractions, times and accelerations are in SI units whatever it says, and so are the lengths in these. The [[cut]]
/// stays as it is: meshes::cuts_of_file() reads it.
/// @param load_case  whose numbers, all of them, are ones that arithmetic can square
/// @throws support::InputError with file, line and remedy
void bring_to_metres(toml::table &load_case);

} // namespace livermark::load_cases
