#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::experiments {

/// The cells of a CSV file from outside. Quotes and blanks around cells are left out; lines without any text are no
/// rows.
struct CsvRow {
    std::string place; ///< "file:line", for messages
    std::vector<std::string> cells;
};
/// @throws support::InputError if it cannot be read
std::vector<CsvRow> read_csv(const std::filesystem::path &file);

/// A finite number of a cell.
/// @throws support::InputError
double number_in(const CsvRow &row, std::size_t column);

/// A table of markers:
///
///     marker,drives,x,y,z,pressed_x,pressed_y,pressed_z
///     a1,,10.0,12.5,30.0,10.1,12.4,28.9
///     p7,z_max,10.0,12.5,60.0,10.0,12.5,57.0
///
/// with the name of a marker, the patch that it drives or nothing, where it was at rest, and where it was in each
/// state. A marker that was not seen in a state has empty cells there.
struct MarkerTable {
    std::vector<std::string> names, drives;                 ///< (K)
    std::vector<core::Vector3> rest;                        ///< (K) [m]
    std::vector<std::string> states;                        ///< (S)
    std::vector<std::vector<core::Vector3>> displacement{}; ///< (S) of (K) [m], NaN where not seen
};

/// @param metres_per_unit  of the file
/// @throws support::InputError with file, line and remedy: another header, a cell that is no number, a marker that is
///   there twice or that drives a place and was not seen, no markers
MarkerTable read_markers(const std::filesystem::path &file, double metres_per_unit);

} // namespace livermark::experiments
