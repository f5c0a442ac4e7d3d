#pragma once

#include <string>

#include "results/records/needle.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// A row for each run of a needle in the arena, by mesh and budget, the best target first: how far the target is from
/// that of the reference when the hand has led the tip there [mm], the same of the whole path of the needle [%], the
/// largest force on the way in, its slope and the largest pull out, each with what it is off by [%], and what a frame
/// costs.
Layout needle_arena_table(const NeedleArena &arena);

/// Sentences on the needle, its reference with its error bar, and the methods that are left out.
std::string needle_arena_note(const NeedleStudy &study);

} // namespace livermark::results
