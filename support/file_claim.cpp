#include "support/file_claim.hpp"

#include <cerrno>
#include <chrono>
#include <fcntl.h>
#include <fmt/format.h>
#include <map>
#include <mutex>
#include <sys/stat.h>
#include <system_error>
#include <thread>
#include <unistd.h>

#include "support/fnv_hash.hpp"
#include "support/input_error.hpp"

namespace livermark::support {

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
    throw InputError(fmt::format("{}: another livermark{} is about to write this file; wait for its end, or choose "
                                 "another --output",
                                 file.string(), is_known ? fmt::format(" (process {})", lock.l_pid) : ""));
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
