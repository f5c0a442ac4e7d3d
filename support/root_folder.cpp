#include "support/root_folder.hpp"

#include <cstdlib>

namespace livermark::support {

std::filesystem::path root_folder() {
    const char *root = std::getenv("LIVERMARK_ROOT"); // NOLINT(concurrency-mt-unsafe): nobody changes the environment
    return root ? root : LIVERMARK_SOURCE_DIR;
}

} // namespace livermark::support
