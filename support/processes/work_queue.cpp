#include "support/processes/work_queue.hpp"

#include <algorithm>
#include <cstddef>

namespace livermark::support {

WorkQueue::WorkQueue(std::span<const int> group, std::span<const std::vector<int>> waits_for)
    : waits_for_(waits_for), is_done_(group.size(), 0) {
    for (std::size_t item = 0; item < group.size(); ++item) {
        if (static_cast<std::size_t>(group[item]) >= groups_.size())
            groups_.resize(group[item] + 1);
        groups_[group[item]].items.push_back(static_cast<int>(item));
    }
}

std::optional<int> WorkQueue::next(int &at) {
    if (at < 0 || !has_something(groups_[at]))
        at = other_group();
    if (at < 0)
        return std::nullopt;
    auto &group = groups_[at];
    group.is_begun = true;
    const auto place = first_to_begin(group);
    const int item = *place;
    group.items.erase(place);
    return item;
}

std::deque<int>::const_iterator WorkQueue::first_to_begin(const Group &group) const {
    return std::ranges::find_if(group.items, [&](int item) {
        return static_cast<std::size_t>(item) >= waits_for_.size() ||
               std::ranges::all_of(waits_for_[item], [&](int other) { return is_done_[other] != 0; });
    });
}

int WorkQueue::other_group() const {
    int best = -1;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        if (!has_something(groups_[g]))
            continue;
        if (!groups_[g].is_begun)
            return static_cast<int>(g);
        if (best < 0 || groups_[g].items.size() > groups_[best].items.size())
            best = static_cast<int>(g);
    }
    return best;
}

} // namespace livermark::support
