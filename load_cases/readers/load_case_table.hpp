#pragma once

#include <filesystem>

#include "core/load_case.hpp"
#include "support/toml_input.hpp"

namespace livermark::load_cases {

/// A load case that is a part of another file; see read_load_case() for what a table may hold.
/// @param file  gives the name of the load case, and the place in messages
/// @param table  gets its lengths in metres, see bring_to_metres()
/// @return without its text
/// @throws support::InputError as read_load_case()
core::LoadCase load_case_of_table(toml::table &table, const std::filesystem::path &file, const core::TetraMesh &mesh);

} // namespace livermark::load_cases
