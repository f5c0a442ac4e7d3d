#pragma once

#include "results/records/needle.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// A row for each needle and model, the reference first: where the target is when the tip is where it was [mm], and how
/// far from that of the reference; how much tissue is left before the tip [mm]; the force of the hand there, the
/// largest on the way in and the largest pull on the way out [N]; the error of the force on the way in [%].
Layout needle_table(const NeedleFile &file);

/// A sentence on each reference: what its last refinement changed.
std::string needle_note(const NeedleFile &file);

} // namespace livermark::results
