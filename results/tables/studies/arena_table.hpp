#pragma once

#include <string>

#include "results/records/arena.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// A row for each method, setting and budget, mesh by mesh and the best of the contact errors first.
/// "-" where a program that moved by itself does not say it.
Layout arena_table(const Arena &arena);

/// What its columns are.
std::string arena_legend();

/// A row for each method and mesh: the error in contact within each budget, of the best setting, and the least time
/// of a frame within which it was 20, 10 and 5 %.
Layout arena_overview(const Arena &arena);

/// What its columns are.
std::string overview_legend();

/// The same with the forces on the tool in place of errors, where there is no reference: mesh by mesh.
Layout arena_forces(const Arena &arena);

/// A row for each run with given iterations, method by method: errors, and by how much the force when the slide begins
/// is above that of the reference, which is the stiffness at the tool that the method has with so many.
Layout arena_series(const Arena &arena);

/// What the tool did, for the head of a table.
std::string tool_of(const Arena &arena);

/// A sentence on methods whose effort was found on a busy machine; empty if there are none.
std::string calibration_note(const Arena &arena);

} // namespace livermark::results
