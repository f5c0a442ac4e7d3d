#pragma once

#include "core/load_case.hpp"
#include "support/toml_input.hpp"

namespace livermark::load_cases {

/// Reads the [tool] of a load case in which one moves.
/// @param table      the whole file, with a [tool]
/// @param load_case  with its conditions on the mesh already
/// @throws support::InputError for what load_case_reader.hpp does not allow
core::ToolMotion read_tool(const toml::table &table, const core::LoadCase &load_case);

} // namespace livermark::load_cases
