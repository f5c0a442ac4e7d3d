#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/problem.hpp"
#include "core/tool/tool_motion.hpp"
#include "results/records/result.hpp"

namespace livermark::results {

/// What motions under a tool are judged by.
struct ToolReference {
    std::string model;
    int level = 0; ///< of refinement
    int steps_per_frame = 0;
    core::ToolHistory history;
    core::ToolErrors last_refinement; ///< of the motion before the last refinement, from this one
    core::ToolErrors half_steps;      ///< of the motion with half as many steps, on the mesh as it is
};

/// Writes it with its fingerprint (reference_file.hpp) and where it comes from.
/// @throws support::InputError if the place cannot be written to
void write_tool_reference(const std::filesystem::path &path, const ToolReference &reference,
                          const core::Problem &problem, const Provenance &provenance);

/// @return nothing if there is no such file, or if it is of something else
/// @throws support::InputError if it is damaged
std::optional<ToolReference> read_tool_reference(const std::filesystem::path &path, const core::Problem &problem,
                                                 const std::string &model);

} // namespace livermark::results
