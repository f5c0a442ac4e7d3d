#include "studies/progress.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <functional>

#include "results/tables/table_layout.hpp"

namespace livermark::studies {

void Steps::next(const std::string &about) {
    ++step_;
    if (report_)
        report_(std::min(step_, num_steps_), num_steps_, about); // a model that solves again is no step more
}

void TimeSpent::stop() {
    if (is_running_)
        add(current_, std::chrono::duration<double>(Clock::now() - start_).count());
    is_running_ = false;
}

void TimeSpent::begin(const std::string &stage) {
    stop();
    current_ = stage;
    is_running_ = true;
    start_ = Clock::now();
}

void TimeSpent::add(const std::string &stage, double seconds) {
    const auto found = std::ranges::find(stages_, stage, &decltype(stages_)::value_type::first);
    if (found != stages_.end())
        found->second += seconds;
    else
        stages_.emplace_back(stage, seconds);
}

void TimeSpent::add(const TimeSpent &other) {
    for (const auto &[stage, seconds] : other.stages_)
        add(stage, seconds);
}

std::string TimeSpent::text() const {
    constexpr double smallest_part = 0.01;
    double total = 0.0;
    for (const auto &[name, seconds] : stages_)
        total += seconds;
    auto longest_first = stages_;
    std::ranges::stable_sort(longest_first, std::greater<>{}, &decltype(stages_)::value_type::second);
    results::Layout layout{{{"stage"}, {"time [s]", true}, {"part [%]", true}}, {}};
    for (const auto &[name, seconds] : longest_first)
        if (seconds >= smallest_part * total)
            layout.rows.push_back({name, results::fixed(seconds, 1), results::fixed(100.0 * seconds / total, 0)});
    return fmt::format("Time spent: {:.1f} s\n\n{}", total, results::to_text(layout));
}

} // namespace livermark::studies
