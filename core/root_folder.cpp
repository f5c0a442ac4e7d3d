#include "core/root_folder.hpp"

#include <cstdlib>

namespace livermark::core {

std::filesystem::path root_folder() {
    const char *root = std::getenv("LIVERMARK_ROOT"); // NOLINT(concurrency-mt-unsafe): nobody changes the environment
    return root ? root : LIVERMARK_SOURCE_DIR;
}

} // namespace livermark::core
