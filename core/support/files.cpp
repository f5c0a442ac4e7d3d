#include "core/support/files.hpp"

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <string_view>
#include <sys/stat.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <utility>

#include "core/support/input_error.hpp"

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

namespace {

/// @param target  named in messages
void write_bytes(const std::filesystem::path &path, const std::filesystem::path &target, std::span<const char> bytes) {
    std::ofstream stream(path, std::ios::binary | std::ios::trunc);
    if (!stream)
        throw InputError(
            "{}: cannot make a file in this directory; check that the directory exists and can be written to",
            target.string());
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream)
        throw InputError("{}: cannot write {} bytes; make room on the disk or choose another place", target.string(),
                         bytes.size());
}

} // namespace

void check_place(const std::filesystem::path &path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (std::filesystem::is_directory(status))
        throw InputError("{}: this is a directory; give the name of a file", path.string());
    // The renaming would put a plain file in the place of a device such as /dev/null.
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
        throw InputError("{}: this is not a plain file; choose another place", path.string());
    const auto directory = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
    if (!std::filesystem::is_directory(directory, error))
        throw InputError("{}: there is no directory {}; make it or choose another place", path.string(),
                         directory.string());
    if (access(directory.c_str(), W_OK | X_OK) != 0)
        throw InputError("{}: cannot make a file in this directory ({}); choose another place or check its permissions",
                         path.string(), std::strerror(errno));
}

void write_whole(const std::filesystem::path &path, std::span<const char> bytes) {
    check_place(path);
    const auto target = std::filesystem::absolute(path);
    // The process number keeps two runs that write the same file from writing into each other's.
    auto temporary = target;
    temporary += fmt::format(".{}.partial", getpid());
    try {
        write_bytes(temporary, path, bytes);
        std::error_code error;
        std::filesystem::rename(temporary, target, error);
        if (error)
            throw InputError("{}: cannot put the file there: {}; choose another place", path.string(), error.message());
    } catch (...) {
        std::error_code ignored;
        std::filesystem::remove(temporary, ignored);
        throw;
    }
}

void check_readable(const std::filesystem::path &file) {
    std::error_code ignored;
    const auto status = std::filesystem::status(file, ignored);
    if (std::filesystem::is_directory(status))
        throw InputError("{}: this is a directory; give a file", file.string());
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
        throw InputError("{}: this is not a plain file; copy what it gives into one", file.string());
    if (access(file.c_str(), R_OK) != 0)
        throw InputError("{}: cannot be read ({}); check the path and its permissions", file.string(),
                         std::strerror(errno));
}

std::string read_text(const std::filesystem::path &file) {
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
    check_readable(file);
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw InputError("{}: cannot be read ({}); check the path and its permissions", file.string(),
                         std::strerror(errno));
    std::ostringstream text;
    if (!(text << stream.rdbuf()))
        throw InputError("{}: the file is empty; save it again", file.string());
    auto bytes = std::move(text).str();
    return bytes.starts_with(byte_order_mark) ? bytes.substr(byte_order_mark.size()) : bytes;
}

namespace {

/// A lock file that this process has open. Closing any descriptor of a file gives back all locks that the process has
/// on it, so there is one for each.
struct LockFile {
    int descriptor = -1;
    int num_claims = 0;
};

struct OpenLockFiles {
    std::mutex mutex;
    std::map<std::filesystem::path, LockFile> by_path;
};

OpenLockFiles &open_lock_files() {
    static OpenLockFiles files;
    return files;
}

/// @param length  0 for the whole file
struct flock lock_of(short type, long place, long length) {
    struct flock lock {};
    lock.l_type = type;
    lock.l_whence = SEEK_SET;
    lock.l_start = place;
    lock.l_len = length;
    return lock;
}

bool set_lock(int descriptor, short type, long place, long length) {
    auto lock = lock_of(type, place, length);
    return fcntl(descriptor, F_SETLK, &lock) == 0;
}

bool belongs_to_another() {
    return errno == EAGAIN || errno == EACCES;
}

/// Whether the file of a descriptor is still there, and no other process has removed it as the last one.
bool is_in_place(int descriptor, const std::filesystem::path &path) {
    struct stat opened {
    }, there{};
    return fstat(descriptor, &opened) == 0 && stat(path.c_str(), &there) == 0 && opened.st_ino == there.st_ino &&
           opened.st_dev == there.st_dev;
}

[[noreturn]] void refuse_claimed(const std::filesystem::path &file, int descriptor, long place) {
    auto lock = lock_of(F_WRLCK, place, 1);
    const bool is_known = fcntl(descriptor, F_GETLK, &lock) == 0 && lock.l_type != F_UNLCK && lock.l_pid > 0;
    throw InputError(
        "{}: another livermark{} is about to write this file; wait for its end, or choose another --output",
        file.string(), is_known ? fmt::format(" (process {})", lock.l_pid) : "");
}

/// Opens a lock file and locks a byte of it.
/// @return the descriptor, -1 where there are no locks
int locked(const std::filesystem::path &path, long place, const std::filesystem::path &file) {
    using namespace std::chrono_literals;
    constexpr int most_tries = 20; // the last claim of another process removes the file, and takes a moment for it
    for (int tries = 1;; ++tries) {
        const int descriptor = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        if (descriptor < 0)
            return -1; // whoever writes there says why not
        const bool is_locked = set_lock(descriptor, F_WRLCK, place, 1);
        if (is_locked && is_in_place(descriptor, path))
            return descriptor;
        if (!is_locked && (!belongs_to_another() || tries == most_tries)) {
            const bool is_claimed = belongs_to_another();
            if (is_claimed)
                try {
                    refuse_claimed(file, descriptor, place);
                } catch (...) {
                    close(descriptor);
                    throw;
                }
            close(descriptor);
            return -1;
        }
        close(descriptor);
        if (!is_locked)
            std::this_thread::sleep_for(10ms);
    }
}

} // namespace

FileClaim::FileClaim(const std::filesystem::path &file) {
    std::error_code error;
    const auto folder = std::filesystem::canonical(file.has_parent_path() ? file.parent_path() : ".", error);
    if (error)
        return;
    lock_ = folder / ".livermark.lock";
    FnvHash hash;
    hash.add(file.filename().string());
    place_ = static_cast<long>(hash.value() % (1U << 30));
    auto &open_files = open_lock_files();
    const std::lock_guard guard(open_files.mutex);
    const auto known = open_files.by_path.find(lock_);
    if (known != open_files.by_path.end()) {
        if (!set_lock(known->second.descriptor, F_WRLCK, place_, 1)) {
            if (belongs_to_another())
                refuse_claimed(file, known->second.descriptor, place_);
            return;
        }
        ++known->second.num_claims;
    } else if (const int descriptor = locked(lock_, place_, file); descriptor >= 0) {
        open_files.by_path[lock_] = {descriptor, 1};
    } else {
        return;
    }
    is_held_ = true;
}

FileClaim::~FileClaim() {
    if (!is_held_)
        return;
    auto &open_files = open_lock_files();
    const std::lock_guard guard(open_files.mutex);
    const auto known = open_files.by_path.find(lock_);
    set_lock(known->second.descriptor, F_UNLCK, place_, 1);
    if (--known->second.num_claims > 0)
        return;
    if (set_lock(known->second.descriptor, F_WRLCK, 0, 0)) // nobody else has claimed anything
        unlink(lock_.c_str());
    close(known->second.descriptor);
    open_files.by_path.erase(known);
}

} // namespace livermark::support
