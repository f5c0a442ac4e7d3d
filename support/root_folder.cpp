#include "support/root_folder.hpp"

#include <cstdlib>
#include <dlfcn.h>
#include <system_error>

namespace livermark::support {

namespace {

namespace fs = std::filesystem;

/// The source tree that a file lies in; empty if in none.
fs::path tree_around(const fs::path &file) {
    std::error_code error;
    for (auto folder = fs::canonical(file, error).parent_path(); !folder.empty(); folder = folder.parent_path()) {
        if (fs::is_regular_file(folder / "meshes" / "liver_healthy.toml", error) &&
            fs::is_directory(folder / "load_cases", error))
            return folder;
        if (folder == folder.root_path())
            break;
    }
    return {};
}

/// The tree of this program, or of the shared object that this code is in.
fs::path own_tree() {
    if (auto tree = tree_around("/proc/self/exe"); !tree.empty())
        return tree;
    Dl_info info{};
    if (dladdr(reinterpret_cast<const void *>(&root_folder), &info) != 0 && info.dli_fname)
        if (auto tree = tree_around(info.dli_fname); !tree.empty())
            return tree;
    return LIVERMARK_SOURCE_DIR;
}

} // namespace

fs::path root_folder() {
    const char *root = std::getenv("LIVERMARK_ROOT"); // NOLINT(concurrency-mt-unsafe): nobody changes the environment
    static const auto own = own_tree();
    return root ? fs::path(root) : own;
}

} // namespace livermark::support
