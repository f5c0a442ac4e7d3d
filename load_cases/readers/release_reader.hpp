#pragma once

#include "core/load_case.hpp"
#include "support/toml_input.hpp"

namespace livermark::load_cases {

/// Reads the [release] and the [[probe]] of a time-dependent load case.
/// @param table      the whole file, with a [release]
/// @param load_case  with its conditions on the mesh already
/// @throws support::InputError for what load_case_reader.hpp does not allow
core::Release read_release(const toml::table &table, const core::TetraMesh &mesh, const core::LoadCase &load_case);

} // namespace livermark::load_cases
