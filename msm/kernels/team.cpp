#include "msm/kernels/team.hpp"

namespace livermark::msm {

Team::Team(int num_threads) : barrier_(num_threads) {
    for (int thread = 1; thread < num_threads; ++thread)
        others_.emplace_back([this, thread] {
            for (int seen = 0;; ++seen) {
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
