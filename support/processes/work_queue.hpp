#pragma once

#include <deque>
#include <optional>
#include <span>
#include <vector>

namespace livermark::support {

/// What is left to do for the workers of run_in_process_pool(), which says who does what.
class WorkQueue {
  public:
    /// @param group      shape (I) the group of each item, >= 0
    /// @param waits_for  of each item the items that have to be done before it begins; may be shorter, and has to live
    ///   as long as this
    WorkQueue(std::span<const int> group, std::span<const std::vector<int>> waits_for);

    /// @param at  the group that the worker is at, or -1; where it goes on
    /// @return nothing if all is begun, or has to wait
    std::optional<int> next(int &at);

    void done(int item) { is_done_[item] = 1; }

  private:
    struct Group {
        std::deque<int> items;
        bool is_begun = false;
    };

    std::deque<int>::const_iterator first_to_begin(const Group &group) const;
    bool has_something(const Group &group) const { return first_to_begin(group) != group.items.end(); }
    int other_group() const;

    std::span<const std::vector<int>> waits_for_;
    std::vector<char> is_done_;
    std::vector<Group> groups_;
};

} // namespace livermark::support
