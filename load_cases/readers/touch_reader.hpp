#pragma once

#include "core/load_case.hpp"
#include "support/toml_input.hpp"

namespace livermark::load_cases {

/// Reads the ball that touches, see load_case_reader.hpp, and brings it to where it just touches the body at rest.
/// @param table      the whole file, with a [touch]
/// @param load_case  with all its conditions; gets the constraint "touch"
/// @throws support::InputError for what load_case_reader.hpp does not allow, NotOnBody where the ball would touch what
///         is held
core::TouchingTool read_touch(const toml::table &table, const core::TetraMesh &mesh, core::LoadCase &load_case);

} // namespace livermark::load_cases
