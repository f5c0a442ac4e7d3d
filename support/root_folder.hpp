#pragma once

#include <filesystem>

namespace livermark::support {

/// Where the bodies, load cases and scripts that ship are: the environment variable LIVERMARK_ROOT; or the source tree
/// that this program or extension module lies in, so that a copied tree reads itself; or the one that it was built
/// from.
std::filesystem::path root_folder();

} // namespace livermark::support
