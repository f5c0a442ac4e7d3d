#pragma once

#include <string>
#include <vector>

#include "core/support/processes/child_process.hpp"

/// The program that is linked with ITK and CGAL, `livermark-segment`, beside this one.
namespace livermark::cli {

inline constexpr const char *command_that_builds = "scripts/bootstrap --program --segmentation";

bool has_segment_program();

/// Lets the program do something; its errors go where ours go. Builds it first if it is missing.
/// @return its exit status, 0 or 1, and what it has printed
/// @throws support::InputError if it refuses, or is missing and cannot be built; std::runtime_error if it fails
support::Printed segment(std::vector<std::string> words);

} // namespace livermark::cli
