#pragma once

#include <filesystem>
#include <string>

#include "core/problem.hpp"

namespace livermark::studies {

/// Makes the folder for the result files of a body, <output>/<body>.
/// @throws support::InputError if it cannot be made
std::filesystem::path make_output_folder(const std::filesystem::path &output, const core::Problem &problem);
/// The same by name.
std::filesystem::path make_output_folder(const std::filesystem::path &output, const std::string &name);

} // namespace livermark::studies
