#pragma once

#include "results/records/measured_needle.hpp"
#include "results/records/needle.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// A row for each needle and model, the reference first: where the target is when the tip is where it was [mm], and how
/// far from that of the reference; how much tissue is left before the tip [mm]; the force of the hand there, the
/// largest on the way in (when it punctures included) and the largest pull on the way out [N]; the error of the force
/// on the way in [%].
Layout needle_table(const NeedleFile &file);

/// A sentence on where models leave the small regime; empty where none does.
std::string limit_note(const NeedleStudy &study);

/// The same of each needle, where energies do not balance or a body came to no rest, and a sentence on each reference:
/// what its last refinement changed.
std::string needle_note(const NeedleFile &file);

/// A row for each stretch of a measured way: the mean, lowest and highest force there, and that of each model [N].
Layout measured_needle_table(const MeasuredNeedle &measured);

/// A row for each model: what was fitted, and how far its force is from the measured one before and behind the puncture
/// [N]; and the work of the hand [mJ], beside the measured one.
Layout fitted_needle_table(const MeasuredNeedle &measured);

} // namespace livermark::results
