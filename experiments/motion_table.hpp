#pragma once

#include <filesystem>
#include <span>

#include "experiments/experiment.hpp"

namespace livermark::experiments {

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

} // namespace livermark::experiments
