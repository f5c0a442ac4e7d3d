#pragma once

#include <atomic>
#include <functional>
#include <memory>

namespace livermark::msm {

/// Barrier at which the threads of a pool wait for each other. It spins, because a phase of a step takes microseconds
/// and to be woken takes as long; after a while it lets others have the core.
class Barrier {
  public:
    explicit Barrier(int num_threads) : num_threads_(num_threads) {}

    using Round = unsigned int; ///< of waiting; after very many they begin again

    void wait() { wait_for(arrive()); }

    /// The same in two parts, between which a thread may do what the others do not have to wait for.
    /// @return what to wait for
    Round arrive() { return num_threads_ > 1 ? tell_others() : 0; }
    void wait_for(Round round) {
        if (num_threads_ > 1)
            wait_for_others(round);
    }

  private:
    Round tell_others();
    void wait_for_others(Round round);

    int num_threads_;
    alignas(64) std::atomic<int> num_here_ = 0;
    alignas(64) std::atomic<Round> round_ = 0;
};

/// Threads that do the same work together, again and again. They sleep where nothing comes for some 50 microseconds:
/// steps that are asked for one by one would all wait until everybody is awake. With LIVERMARK_WITHOUT_THREADS, as in
/// WebAssembly, the caller does all alone. A process that was forked while nobody ran has a pool of its own.
class ThreadPool {
  public:
    /// @param num_threads  >= 1, the caller among them
    /// @throws std::system_error if the system starts no more threads
    explicit ThreadPool(int num_threads);
    ~ThreadPool();
    ThreadPool(const ThreadPool &) = delete;
    ThreadPool &operator=(const ThreadPool &) = delete;

    /// Calls work(thread, barrier) once for each thread in [0, size()), in parallel, and returns when all are done.
    void run(const std::function<void(int, Barrier &)> &work);

    int size() const { return num_threads_; }

  private:
    struct Others;
    int num_threads_;
    Barrier barrier_;
    std::unique_ptr<Others> others_;
};

} // namespace livermark::msm
