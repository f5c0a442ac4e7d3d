#include "msm/kernels/team.hpp"

namespace livermark::msm {

namespace {

/// How often a thread looks for new work, and how often it then lets others have the core, before it goes to sleep.
constexpr int num_looks = 4000, num_yields = 100;

} // namespace

Team::Team(int num_threads) : barrier_(num_threads) {
    for (int thread = 1; thread < num_threads; ++thread)
        others_.emplace_back([this, thread] {
            for (int seen = 0;; ++seen) {
                for (int look = 0; look < num_looks + num_yields && call_.load(std::memory_order_acquire) == seen;
                     ++look)
                    if (look > num_looks)
                        std::this_thread::yield();
                call_.wait(seen);
                if (work_ == nullptr)
                    return;
                (*work_)(thread, barrier_);
                barrier_.wait();
            }
        });
}

Team::~Team() {
    work_ = nullptr;
    ++call_;
    call_.notify_all();
}

void Team::run(const std::function<void(int, Barrier &)> &work) {
    work_ = &work;
    ++call_;
    call_.notify_all();
    work(0, barrier_);
    barrier_.wait();
}

} // namespace livermark::msm
