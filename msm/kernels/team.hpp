#pragma once

#include <atomic>
#include <functional>
#include <thread>
#include <vector>

namespace livermark::msm {

/// Where the threads of a team wait for each other. It spins, because a phase of a step takes microseconds and to be
/// woken takes as long; after a while it lets others have the core.
class Barrier {
  public:
    explicit Barrier(int num_threads) : num_threads_(num_threads) {}

    void wait() {
        if (num_threads_ == 1)
            return;
        const int round = round_.load(std::memory_order_relaxed);
        if (num_here_.fetch_add(1, std::memory_order_acq_rel) == num_threads_ - 1) {
            num_here_.store(0, std::memory_order_relaxed);
            round_.store(round + 1, std::memory_order_release);
            return;
        }
        for (int spins = 0; round_.load(std::memory_order_acquire) == round; ++spins)
            if (spins > patience)
                std::this_thread::yield();
    }

  private:
    static constexpr int patience = 2000;
    int num_threads_;
    alignas(64) std::atomic<int> num_here_ = 0;
    alignas(64) std::atomic<int> round_ = 0;
};

/// Threads that do the same work together, again and again. They sleep where nothing comes for some 50 microseconds:
/// steps that are asked for one by one would all wait until everybody is awake.
class Team {
  public:
    /// @param num_threads  >= 1, the caller among them
    explicit Team(int num_threads);
    ~Team();
    Team(const Team &) = delete;
    Team &operator=(const Team &) = delete;

    /// Calls work(thread, barrier) once for each thread in [0, size()), in parallel, and returns when all are done.
    void run(const std::function<void(int, Barrier &)> &work);

    int size() const { return static_cast<int>(others_.size()) + 1; }

  private:
    Barrier barrier_;
    const std::function<void(int, Barrier &)> *work_ = nullptr; ///< nothing ends the threads
    std::atomic<int> call_ = 0;
    std::vector<std::jthread> others_;
};

} // namespace livermark::msm
