#include "core/side_by_side.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <exception>
#include <fstream>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace livermark::core {

namespace {

/// What is left to do, for several threads.
class Queue {
  public:
    explicit Queue(std::span<const int> group) {
        for (std::size_t item = 0; item < group.size(); ++item) {
            if (static_cast<std::size_t>(group[item]) >= groups_.size())
                groups_.resize(group[item] + 1);
            groups_[group[item]].items.push_back(static_cast<int>(item));
        }
    }

    /// @param at  the group that the worker is at, or -1; where it goes on
    std::optional<int> next(int &at) {
        const std::scoped_lock lock(mutex_);
        if (at < 0 || groups_[at].items.empty())
            at = other_group();
        if (at < 0)
            return std::nullopt;
        auto &[items, is_begun] = groups_[at];
        is_begun = true;
        const int item = items.front();
        items.pop_front();
        return item;
    }

    void drop_all() {
        const std::scoped_lock lock(mutex_);
        for (auto &group : groups_)
            group.items.clear();
    }

  private:
    struct Group {
        std::deque<int> items;
        bool is_begun = false;
    };

    int other_group() const {
        int best = -1;
        for (std::size_t g = 0; g < groups_.size(); ++g) {
            if (groups_[g].items.empty())
                continue;
            if (!groups_[g].is_begun)
                return static_cast<int>(g);
            if (best < 0 || groups_[g].items.size() > groups_[best].items.size())
                best = static_cast<int>(g);
        }
        return best;
    }

    std::mutex mutex_;
    std::vector<Group> groups_;
};

/// @return [byte] that a new process could have; infinite where the system does not say
double available_memory() {
    std::ifstream lines("/proc/meminfo");
    std::string word;
    while (lines >> word)
        if (double kibibytes = 0.0; word == "MemAvailable:" && lines >> kibibytes)
            return 1024.0 * kibibytes;
    return std::numeric_limits<double>::infinity();
}

} // namespace

void side_by_side(std::span<const int> group, int num_workers, const std::function<void(int, int)> &work) {
    Queue queue(group);
    std::mutex mutex;
    std::exception_ptr first_fault;
    const auto work_through = [&](int worker) {
        int at = -1;
        while (const auto item = queue.next(at)) {
            try {
                work(worker, *item);
            } catch (...) {
                queue.drop_all();
                const std::scoped_lock lock(mutex);
                if (!first_fault)
                    first_fault = std::current_exception();
            }
        }
    };
    {
        std::vector<std::jthread> others;
        for (int worker = 1; worker < std::min(num_workers, static_cast<int>(group.size())); ++worker)
            others.emplace_back(work_through, worker);
        work_through(0);
    }
    if (first_fault)
        std::rethrow_exception(first_fault);
}

int workers_that_fit(double bytes_per_worker) {
    const auto cores = static_cast<double>(std::max(1U, std::thread::hardware_concurrency()));
    return static_cast<int>(std::clamp(std::floor(available_memory() / bytes_per_worker), 1.0, cores));
}

} // namespace livermark::core
