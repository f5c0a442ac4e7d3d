#include "msm/kernels/thread_pool.hpp"

#ifdef LIVERMARK_WITHOUT_THREADS

namespace livermark::msm {

Barrier::Round Barrier::tell_others() {
    return 0;
}
void Barrier::wait_for_others(Round /*round*/) {}

struct ThreadPool::Others {};

ThreadPool::ThreadPool(int /*num_threads*/) : num_threads_(1), barrier_(1) {}

ThreadPool::~ThreadPool() = default;

void ThreadPool::run(const std::function<void(int, Barrier &)> &work) {
    work(0, barrier_);
}

} // namespace livermark::msm

#else

#include <thread>
#include <utility>
#include <vector>

#include "core/support/processes/own_process.hpp"

namespace livermark::msm {

namespace {

/// Number of looks of a thread whether the last one has come before it lets others have the core.
constexpr int patience = 2000;
/// Number of looks of a thread for new work, and of times that it then lets others have the core, before it goes to
/// sleep.
constexpr int num_looks = 4000, num_yields = 100;

} // namespace

Barrier::Round Barrier::tell_others() {
    const Round round = round_.load(std::memory_order_relaxed);
    if (num_here_.fetch_add(1, std::memory_order_acq_rel) == num_threads_ - 1) {
        num_here_.store(0, std::memory_order_relaxed);
        round_.store(round + 1, std::memory_order_release);
    }
    return round;
}

void Barrier::wait_for_others(Round round) {
    for (int spins = 0; round_.load(std::memory_order_acquire) == round; ++spins)
        if (spins > patience)
            std::this_thread::yield();
}

struct ThreadPool::Others {
    const std::function<void(int, Barrier &)> *work = nullptr; ///< nothing ends the threads
    std::atomic<int> call = 0;
    std::vector<std::jthread> threads;
    unsigned forks = support::fork_count(); ///< of the process that has the threads

    Others(int num_threads, Barrier &barrier) {
        try {
            for (int thread = 1; thread < num_threads; ++thread)
                threads.emplace_back([this, &barrier, thread] { work_along(thread, barrier); });
        } catch (...) { // those that are there already would be waited for
            call_all(nullptr);
            throw;
        }
    }

    void work_along(int thread, Barrier &barrier) {
        for (int seen = 0;; ++seen) {
            for (int look = 0; look < num_looks + num_yields && call.load(std::memory_order_acquire) == seen; ++look)
                if (look > num_looks)
                    std::this_thread::yield();
            call.wait(seen);
            if (work == nullptr)
                return;
            (*work)(thread, barrier);
            barrier.wait();
        }
    }

    void call_all(const std::function<void(int, Barrier &)> *next) {
        work = next;
        ++call;
        call.notify_all();
    }
};

ThreadPool::ThreadPool(int num_threads)
    : num_threads_(num_threads), barrier_(num_threads), others_(std::make_unique<Others>(num_threads, barrier_)) {}

ThreadPool::~ThreadPool() {
    if (others_->forks == support::fork_count())
        others_->call_all(nullptr);
    else
        static_cast<void>(others_.release()); // threads of another process, for which nobody here can wait
}

void ThreadPool::run(const std::function<void(int, Barrier &)> &work) {
    if (others_->forks != support::fork_count()) {
        auto own = std::make_unique<Others>(num_threads_, barrier_);
        static_cast<void>(others_.release()); // as above
        others_ = std::move(own);
    }
    others_->call_all(&work);
    work(0, barrier_);
    barrier_.wait();
}

} // namespace livermark::msm

#endif
