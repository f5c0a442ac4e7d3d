#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "core/problem.hpp"
#include "results/hdf5/references.hpp"

namespace livermark::studies {

/// The model that motions under a tool are judged by.
inline constexpr const char *tool_reference_model = "fem_p2_neo_hookean_refined_at_rims";

/// The same on the mesh as it is.
inline constexpr const char *coarse_tool_reference_model = "fem_p2_neo_hookean";

/// How far it goes.
struct ToolReferenceOptions {
    int level = 2; ///< of refinement at the rims of places, at least 1
    int steps_per_frame = 4;
};

/// Solves it, on the mesh as it is, on the finest one and on the one before, and with half the steps on the first:
/// minutes to an hour.
/// @param starting  called before each motion
/// @throws support::InputError where a motion finds no next step
results::ToolReference solve_tool_reference(const core::Problem &problem, const ToolReferenceOptions &options,
                                            const std::function<void(const std::string &)> &starting);

/// That which is stored.
/// @throws support::InputError if none is, with the command that makes it
results::ToolReference stored_tool_reference(const core::Problem &problem);

/// A coarse one in minutes, for a body that has none: quadratic tetrahedra on the mesh as it is, in two steps a frame.
/// Its own error is not known (NaN). It is kept at the path, and read from there if it is that of the problem.
/// @param starting  called before it is solved
/// @throws support::InputError where the motion finds no next step, and where the path cannot be written
results::ToolReference coarse_tool_reference(const core::Problem &problem, const std::filesystem::path &path,
                                             const std::string &command_line,
                                             const std::function<void(const std::string &)> &starting);

/// Whether one is stored that stored_tool_reference() finds.
bool has_stored_tool_reference(const core::Problem &problem);

/// Stores one where stored_tool_reference() finds it.
void store_tool_reference(const results::ToolReference &reference, const core::Problem &problem,
                          const std::string &command_line);

} // namespace livermark::studies
