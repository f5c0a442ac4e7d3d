#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/places.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "load_cases/experiments/experiment.hpp"

namespace livermark::experiments {

/// Cells of a line of a CSV file from outside.
struct CsvRow {
    std::string place; ///< "file:line", for messages
    std::vector<std::string> cells;
};

/// Rows of a CSV file. Quotes and blanks around cells are left out; lines without any text are no rows.
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

/// Reads a table of markers over time:
///
///     time,a1_x,a1_y,a1_z,p7_x,p7_y,p7_z
///     0.00,10.1,12.4,28.9,10.0,12.5,57.0
///     0.01,10.1,12.4,28.7,10.0,12.5,56.6
///
/// with times in seconds, at equal intervals, and positions. The body is at rest in the first record, and let go then.
/// @param markers          each has its three columns, in any order
/// @param metres_per_unit  of positions
/// @throws support::InputError with file, line and remedy: other columns, fewer than 16 records, times that are not
///   evenly spaced, a cell that is no number
MarkerMotion read_motion(const std::filesystem::path &file, std::span<const Marker> markers, double metres_per_unit);

/// Displacements at points between the nodes of a mesh.
///
/// In a tetrahedron with barycentric coordinates l_i: u = sum l_i (u_i + g_i (x - x_i) / 2), with g_i the gradient at a
/// node, the mean over its tetrahedra weighted by their volumes. That is exact for affine displacements, and for
/// quadratic ones where the gradients are, so that a coarse mesh does not hide how good a model is. A point outside, as
/// a marker on a peg, moves with the nearest point of the body and the gradient there.
class MarkerField {
  public:
    /// @param mesh  kept alive by the caller
    MarkerField(const core::TetraMesh &mesh, std::span<const core::Vector3> points);

    /// @param displacement  shape (N) of the nodes [m]
    /// @return shape (K) at the points [m]
    std::vector<core::Vector3> at_points(std::span<const core::Vector3> displacement) const;

    /// The nodes that displacements at the points depend on, in ascending order.
    std::vector<int> nodes() const;

    /// (K) how far each point is outside the body [m]; 0 inside
    const std::vector<double> &outside() const { return outside_; }

  private:
    struct Place {
        core::LocatedPoint at;                     ///< the nearest point of the body
        core::Vector3 peg = core::Vector3::Zero(); ///< from there to the point [m]
    };
    Place find(const core::Vector3 &point) const;

    const core::TetraMesh *mesh_;
    std::vector<Place> places_;
    std::vector<double> outside_;
};

} // namespace livermark::experiments
