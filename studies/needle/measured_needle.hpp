#pragma once

#include "results/records/needle.hpp"
#include "studies/needle/needle_study.hpp"

namespace livermark::studies {

/// Puts models beside a measured needle, see experiments::read_needle_curve().
///
/// The needle is the first of the load case, on its way as deep as the measurement goes, with the measured diameter.
/// The surface gives way at the measured force. Two numbers are fitted for each model: one factor of all of Young's
/// moduli, so that this happens at the measured depth; and the friction, by least squares over the stretches behind.
/// Toughness and the radius of the places are those of the load case.
/// @param options  of one body; `output` is not written to
/// @throws support::InputError as drive_needles(), and if the data are not there
results::MeasuredNeedle compare_with_measured(const NeedleOptions &options, const ProgressReport &report);

} // namespace livermark::studies
