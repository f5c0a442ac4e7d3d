#pragma once

#include <filesystem>

namespace livermark::support {

/// Where the bodies, load cases, error bands and scripts that ship are: the environment variable LIVERMARK_ROOT, or the
/// source tree that this program was built from.
std::filesystem::path root_folder();

} // namespace livermark::support
