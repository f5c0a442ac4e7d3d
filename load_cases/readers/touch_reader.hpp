#pragma once

#include "core/load_case.hpp"
#include "support/toml_input.hpp"

namespace livermark::load_cases {

/// Where a ball is that just touches a body, and what facet.
struct FirstTouch {
    core::Vector3 centre; ///< [m]
    int facet;
};

/// Where a ball that comes from far away along a line first touches the body at rest. It always moves by the gap that
/// is left, which never leads into the body.
/// @param onto       a point of the line [m]
/// @param direction  along which it comes, of length 1
FirstTouch first_touch(const core::TetraMesh &mesh, const core::Vector3 &onto, const core::Vector3 &direction,
                       double radius);

/// Reads the ball that touches, see load_case_reader.hpp, and brings it to where it just touches the body at rest.
/// @param table      the whole file, with a [touch]
/// @param load_case  with all its conditions; gets the constraint "touch"
/// @throws support::InputError for what load_case_reader.hpp does not allow, NotOnBody where the ball would touch what
///         is held
core::TouchingTool read_touch(const toml::table &table, const core::TetraMesh &mesh, core::LoadCase &load_case);

} // namespace livermark::load_cases
