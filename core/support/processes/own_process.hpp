#pragma once

#include <atomic>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <pthread.h>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

extern "C" void omp_set_max_active_levels(int levels); // the OpenMP runtime comes with CHOLMOD

/// Rules of fork(): the new process has the memory of the old one, but only the thread that
/// called. Threads that others wait for are not there, and a mutex that another thread held stays locked.
namespace livermark::support {

namespace forks {
inline std::atomic<unsigned> count = 0;
}

/// Forks between the process in which this was called first and this one: another number than before tells of a new
/// process.
inline unsigned fork_count() {
    [[maybe_unused]] static const int registered = pthread_atfork(nullptr, nullptr, [] { ++forks::count; });
    return forks::count;
}

/// A mutex of the process, one for each purpose. It is free in a new process, whoever held it in the old one: for work
/// that is whole again when it is begun anew.
template <class Purpose> std::mutex &mutex_of_process() {
    static std::mutex mutex;
    [[maybe_unused]] static const int registered = pthread_atfork(nullptr, nullptr, [] { std::construct_at(&mutex); });
    return mutex;
}

/// Remedy where a run needs more memory than there is.
inline constexpr std::string_view memory_remedy = "take --jobs 1, or a mesh of fewer tetrahedra";

/// Why something failed, for a message: what the error says, or, where memory ran out, that and a remedy.
std::string reason_of(const std::exception &error, std::string_view remedy = memory_remedy);

/// Gives the machine back what was freed: blocks that are still there keep an allocator from doing it by itself.
void return_freed_memory();

/// Share of the machine that this process may use.
struct MachineShare {
    int cores = 1;      ///< >= 1
    double bytes = 0.0; ///< of memory that new processes could have [byte]; infinite where the system does not say
};

/// The cores and the memory that are left to this process: of the machine, and of the control groups of Linux that it
/// is in, in which containers, batch systems and systemd put limits (cgroup v1 and v2). A group and those above it
/// count. Memory that a group has only as a cache of files is left.
/// @param root  where proc/ and the mounted control groups are: "/", or for a test a folder
MachineShare share_of_machine(const std::filesystem::path &root = "/");

/// Values one behind the other as bytes, for a process of the same program: see own_process.hpp.
class Packer {
  public:
    template <class Value> void put(const Value &value) {
        static_assert(std::is_trivially_copyable_v<Value>);
        append(&value, sizeof(value));
    }
    void put(const std::string &text) {
        put(static_cast<std::uint64_t>(text.size()));
        append(text.data(), text.size());
    }
    template <class Value> void put(const std::vector<Value> &values) {
        put(static_cast<std::uint64_t>(values.size()));
        if constexpr (std::is_trivially_copyable_v<Value>)
            append(values.data(), values.size() * sizeof(Value));
        else
            for (const auto &value : values)
                put(value);
    }
    std::string bytes() && { return std::move(bytes_); }

  private:
    void append(const void *data, std::size_t size) { bytes_.append(static_cast<const char *>(data), size); }
    std::string bytes_;
};

/// The same values in the same order.
class Unpacker {
  public:
    explicit Unpacker(std::string_view bytes) : bytes_(bytes) {}

    template <class Value> void get(Value &value) { take(&value, sizeof(value)); }
    void get(std::string &text) {
        text.resize(count());
        take(text.data(), text.size());
    }
    template <class Value> void get(std::vector<Value> &values) {
        values.resize(count());
        if constexpr (std::is_trivially_copyable_v<Value>)
            take(values.data(), values.size() * sizeof(Value));
        else
            for (auto &value : values)
                get(value);
    }

  private:
    std::size_t count() {
        std::uint64_t number = 0;
        get(number);
        if (number > bytes_.size()) // no value has less than a byte
            throw std::runtime_error("a process has sent less than it said");
        return static_cast<std::size_t>(number);
    }
    void take(void *to, std::size_t size) {
        if (size > bytes_.size())
            throw std::runtime_error("a process has sent less than it said");
        if (size > 0)
            std::memcpy(to, bytes_.data(), size);
        bytes_.remove_prefix(size);
    }
    std::string_view bytes_;
};

/// Names that somebody else's reader may take for a file.
struct ReaderLimits {
    int seconds = 60;                             ///< of computing; half a minute and three times as long by the clock
    std::uint64_t bytes = std::uint64_t{1} << 30; ///< beside what the process has
};

/// Limits in proportion to the bytes of a file, or of the files in a folder: a file of two kilobytes has no right to
/// gigabytes.
/// @param bytes_per_byte  of memory, of what may be compressed
ReaderLimits limits_for(const std::filesystem::path &file, double bytes_per_byte);

/// Does work on a file in a process of its own, so that a library that crashes, hangs or fills the memory on a damaged
/// file ends that process alone. What the libraries print is dropped.
/// @param file  named in messages
/// @param work  returns what is to come back; may throw InputError. Nothing else of what it does is seen here
/// @throws InputError of the work, or one that says how the process ended
std::string in_own_process(const std::filesystem::path &file, const ReaderLimits &limits,
                           const std::function<std::string()> &work);

/// Sends a text home from where an item is done.
using SendMessage = std::function<void(const std::string &text)>;

/// Does every item of some work once, by several workers, each a process of its own: BLAS, CHOLMOD and HDF5 as they are
/// packaged let one thread of a process in at a time. One worker does all in this process. Others may not be made by
/// a process that has several threads or MPI.
///
/// Items of one group share what a worker keeps for them, say the factors of a body. So a worker stays with its group
/// as long as that has items left that need not wait, then begins the first group that nobody has begun, and at last
/// helps with the one that has most left. Which worker does an item is up to chance: no result may depend on it.
/// @param group        shape (I) the group of each item, >= 0
/// @param waits_for    of each item the items before it that have to be done before it begins; may be shorter
/// @param num_workers  >= 1
/// @param work         called for an item; what it changes in memory may stay in the worker, what it sends comes home
/// @param receive      called in this process with an item and each text, in the order of sending
/// @param lost  called with an item whose worker has died or ran out of memory, and how: "Killed" as signals are named,
///   "ended by itself" or "out of memory". The item counts as done then, and another worker takes the place. Without it
///   that is a fault of the work
/// @throws InputError or std::runtime_error as the work threw first; std::runtime_error if a worker is lost and nobody
///   is told, or if no worker can be started; the other workers are then stopped
void run_in_process_pool(std::span<const int> group, int num_workers,
                         const std::function<void(int item, const SendMessage &)> &work,
                         const std::function<void(int item, const std::string &text)> &receive,
                         std::span<const std::vector<int>> waits_for = {},
                         const std::function<void(int item, const std::string &how)> &lost = {});

/// Number of workers that cores and memory allow.
/// @param bytes_per_worker  that each of them needs
/// @return >= 1
int workers_that_fit(double bytes_per_worker, const MachineShare &share = share_of_machine());

/// Keeps what CHOLMOD would spread over OpenMP threads in the thread that calls this, and then CHOLMOD. Sums do not
/// depend on the machine then, nothing waits in a loop on a core that another process needs, and the process may fork.
inline void keep_openmp_in_this_thread() {
    omp_set_max_active_levels(0);
}

/// Holds every other ordering of a sparse matrix back while it lives. METIS, which CHOLMOD orders with, seeds the
/// random numbers of the C library and draws from them: two orderings at a time draw from one sequence, and find others
/// than each alone. All numbers behind such a factor differ in their last digits then.
inline std::unique_lock<std::mutex> only_ordering() {
    struct Orderings;
    return std::unique_lock(mutex_of_process<Orderings>());
}

/// Holds every other thread that calls BLAS back while it lives. The OpenBLAS for programs of one thread, which CHOLMOD
/// runs on, gives two threads the same buffer, and both find numbers that belong to neither.
inline std::unique_lock<std::mutex> only_in_blas() {
    struct Blas;
    return std::unique_lock(mutex_of_process<Blas>());
}

} // namespace livermark::support
