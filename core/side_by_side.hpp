#pragma once

#include <functional>
#include <span>

namespace livermark::core {

/// Does every item of some work once, by several workers, each in a thread of its own; one worker uses no thread.
///
/// Items of one group share what a worker keeps for them, say the factors of a body. So a worker stays with its group as
/// long as that has items left, then begins the first group that nobody has begun, and at last helps with the one that
/// has most left. Which worker does an item is up to chance: no result may depend on it.
/// @param group        shape (I) the group of each item, >= 0
/// @param num_workers  >= 1
/// @param work         called with worker and item, of each worker for one item at a time
/// @throws whatever the work throws first; items in progress are ended, and no other is begun
void side_by_side(std::span<const int> group, int num_workers, const std::function<void(int worker, int item)> &work);

/// How many workers this process has cores for, and the machine memory.
/// @param bytes_per_worker  that each of them needs
/// @return >= 1
int workers_that_fit(double bytes_per_worker);

} // namespace livermark::core
