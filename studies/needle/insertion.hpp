#pragma once

#include <Eigen/Core>

#include "core/tool/needle/needle.hpp"
#include "core/tool/needle/needle_line.hpp"

namespace livermark::studies {

/// Drives a needle into a body that gives way as a matrix says, and draws it out again.
///
/// The body is elastic and linear, so all that is to be found is forces on the places: those of the shaft along the
/// axis, within friction times the length that each stands for; that of the tip, between nothing and what tears the
/// tissue; and those across, which hold the tissue at the shaft where it was when the tip passed. Where a force is
/// within its limits the tissue sticks to the needle, and at a limit it slides the way of the force (Coulomb's
/// condition with a given limit). These are the conditions of the least 1/2 f . C f - f . b within limits, which has
/// one solution. The tip advances where the tissue tears, until what it exerts is what tearing takes; after the surface
/// has given way it jumps.
/// @param compliance  C, shape (3 K, 3 K) of the places of the line [m/N], see core::Compliance
core::Insertion insert(const Eigen::MatrixXd &compliance, const core::NeedleLine &line, const core::Needle &needle);

} // namespace livermark::studies
