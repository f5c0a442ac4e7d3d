#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <pthread.h>

/// What a process has to know of fork(): the new process has the memory of the old one, but only the thread that
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

} // namespace livermark::support
