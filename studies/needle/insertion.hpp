#pragma once

#include <Eigen/Core>

#include "core/tool/needle/needle.hpp"
#include "core/tool/needle/needle_line.hpp"
#include "core/tool/needle/pushed_body.hpp"

namespace livermark::studies {

/// Drives a needle into a body, and draws it out again.
///
/// What is to be found at each depth of the hand is forces on the places: those of the shaft along the axis, within
/// friction times the length that each stands for; that of the tip, between nothing and what tears the tissue; and
/// those across, which hold the tissue at the shaft where it was when the tip passed. Where a force is within its
/// limits the tissue sticks to the needle, and at a limit it slides the way of the force (Coulomb's condition with a
/// given limit). Where the places move by u = b + C f these are the conditions of the least 1/2 f . C f - f . b within
/// limits, which has one solution. The tip advances where the tissue tears, until what it exerts is what tearing takes;
/// after the surface has given way it jumps.
///
/// A linear body moves by u = C f, so that this is all. Of another one, u = b + C f is what is known of it (see
/// Tissue): the body is pushed with the forces, corrects that, and so on until no place is elsewhere by more than a
/// thousandth of the spacing. Axis, friction over length at rest and what tearing takes are the same for all bodies.
/// Places are of the tissue at rest: in a body that moves far the needle stays on its line in space, and holds tissue
/// that was on that line at rest where it was when the tip passed, as core::MovingNeedle does.
/// @param body  at rest, or near it
/// @return where the body comes to no rest, with the depth in stopped_at: records on the way in are not numbers from
///   there on, those on the way out end
core::Insertion insert(core::PushedBody &body, const core::NeedleLine &line, const core::Needle &needle);

/// Of a linear body.
/// @param compliance  C, shape (3 K, 3 K) of the places of the line [m/N], see core::Compliance
core::Insertion insert(const Eigen::MatrixXd &compliance, const core::NeedleLine &line, const core::Needle &needle);

} // namespace livermark::studies
