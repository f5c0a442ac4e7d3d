#pragma once

#include <string>

namespace livermark::tests {

/// Comparison of a text with the one that was reviewed, tests/golden/<name>.txt. `scripts/golden` writes all of them
/// anew, for a look at what changed. Fails with the first line that differs, or where there is no such file.
/// @param name  lower case and underscores; one for each call
void expect_golden(const std::string &name, const std::string &text);

} // namespace livermark::tests
