#pragma once

namespace livermark::results {

/// Commit that the program was built from; git_commit.cmake writes the definition at every build.
const char *git_commit();

} // namespace livermark::results
