#pragma once

#include "core/load_case.hpp"
#include "support/toml_input.hpp"

namespace livermark::load_cases {

/// Reads what judges a load case, and the path of a large one.
/// @param table      the whole file
/// @param load_case  whose regime and path are set
/// @throws support::InputError for what load_case_reader.hpp does not allow
void read_regime(const toml::table &table, core::LoadCase &load_case);

} // namespace livermark::load_cases
