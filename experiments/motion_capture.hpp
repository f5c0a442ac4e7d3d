#pragma once

#include <filesystem>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::experiments {

/// Markers over time.
struct MotionCapture {
    double frame_rate = 0.0;              ///< [1/s]
    int num_markers = 0;                  ///< Q
    std::vector<core::Vector3> positions; ///< (F, Q), all markers of a frame behind each other, in the unit of the file

    int num_frames() const { return static_cast<int>(positions.size()) / num_markers; }
    const core::Vector3 &at(int frame, int marker) const { return positions[frame * num_markers + marker]; }
};

/// Reads the points of a C3D file with numbers of single precision in the order of Intel processors, and without analog
/// channels: what motion capture systems write today. (The C3D file format, c3d.org, 2008)
/// @throws support::InputError for any other file, one that ends early, a marker that was not seen or is not a number
MotionCapture read_motion_capture(const std::filesystem::path &file);

} // namespace livermark::experiments
