#pragma once

#include "core/problem.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "results/hdf5/io/described.hpp"

namespace livermark::results {

/// Writes /load_case/tool, which the mesh and the load case decide; nothing where the load case has no tool.
void write_tools(hdf5::OutputFile &file, const core::Problem &problem);

/// Writes /comparisons/<model>/tool and its attributes.
/// @param at  /comparisons/<model>
void write_tool_comparison(const hdf5::GroupWriter &at, const core::ToolComparison &tool,
                           const core::LoadCase &load_case);

/// Reads /comparisons/<model>/tool; what its attributes say follows from it.
/// @throws support::InputError for what the schema does not allow
core::ToolComparison read_tool_comparison(const hdf5::GroupReader &at, const core::LoadCase &load_case);

} // namespace livermark::results
