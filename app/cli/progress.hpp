#pragma once

#include <string>
#include <vector>

#include "studies/progress.hpp"

namespace livermark::cli {

/// Says on standard error how far long work is: on a terminal a line that is overwritten, and erased with the last copy
/// of what this returns; elsewhere a plain line for each step.
studies::ProgressReport print_progress();

/// Says on standard error what a user should know of the input, a line for each sentence.
void print_notes(const std::vector<std::string> &notes);

} // namespace livermark::cli
