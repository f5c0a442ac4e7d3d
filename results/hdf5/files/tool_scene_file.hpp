#pragma once

#include <filesystem>
#include <vector>

#include "core/problem.hpp"
#include "core/tool/tool_motion.hpp"
#include "results/records/result.hpp"

namespace livermark::results {

/// Nodes that a tool moves, and where to.
struct ToolNodes {
    std::vector<int> held;                   ///< (H) nodes that never move
    std::vector<int> nodes;                  ///< (T) that the tool has hold of
    std::vector<core::Vector3> displacement; ///< (K, T) of these at each record [m]; of no meaning once it has let go
};

/// Writes the "tool scenes" of results/schema.md: all that a program of somebody else needs to move a body.
/// @param problem  of a load case with a tool
/// @throws support::InputError if the place cannot be written to
void write_tool_scene(const std::filesystem::path &path, const core::Problem &problem, const ToolNodes &tool,
                      const Provenance &provenance);

/// A motion that somebody else has found for such a scene.
struct OutsideMotion {
    core::ToolHistory history;
    double seconds_per_frame = 0.0; ///< as its maker says; NaN if nothing is said
};

/// Reads HDF5 with the datasets displacement, (K, N, 3) of all records or (F, N, 3) of every fourth [m], and force,
/// (K, 3) of the body on the tool [N], and the attribute seconds_per_frame of the root, which may be left out.
/// @throws support::InputError that names the file and the dataset, and says what is wrong and what to do
OutsideMotion read_outside_motion(const std::filesystem::path &path, const core::Problem &problem);

} // namespace livermark::results
