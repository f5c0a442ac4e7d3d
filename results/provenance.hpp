#pragma once

#include <string>

#include "results/records/result.hpp"

namespace livermark::results {

/// Commit that the program was built from; git_commit.cmake writes the definition at every build.
const char *git_commit();

/// This program, the machine that it runs on, and the time.
/// The commit is that of the tree when the program was built: "-dirty" behind it if anything was modified or untracked,
/// "unknown" if it was not built from a git repository.
/// @param command  command line, as the user would type it again
Provenance current_provenance(std::string command);

} // namespace livermark::results
