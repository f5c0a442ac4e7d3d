#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/support/processes/own_process.hpp"

namespace livermark::support {

/// Sends a text home from where an item is done.
using SendMessage = std::function<void(const std::string &text)>;

/// Does every item of some work once, by several workers, each a process of its own: BLAS, CHOLMOD and HDF5 as they are
/// packaged let one thread of a process in at a time. One worker does all in this process. Others may not be made by
/// a process that has several threads or MPI.
///
/// Items of one group share what a worker keeps for them, say the factors of a body. So a worker stays with its group
/// as long as that has items left that need not wait, then begins the first group that nobody has begun, and at last
/// helps with the one that has most left. Which worker does an item is up to chance: no result may depend on it.
/// @param group        shape (I) the group of each item, >= 0
/// @param waits_for    of each item the items before it that have to be done before it begins; may be shorter
/// @param num_workers  >= 1
/// @param work         called for an item; what it changes in memory may stay in the worker, what it sends comes home
/// @param receive      called in this process with an item and each text, in the order of sending
/// @param lost  called with an item whose worker has died or ran out of memory, and how: "Killed" as signals are named,
///   "ended by itself" or "out of memory". The item counts as done then, and another worker takes the place. Without it
///   that is a fault of the work
/// @throws InputError or std::runtime_error as the work threw first; std::runtime_error if a worker is lost and nobody
///   is told, or if no worker can be started; the other workers are then stopped
void run_in_process_pool(std::span<const int> group, int num_workers,
                         const std::function<void(int item, const SendMessage &)> &work,
                         const std::function<void(int item, const std::string &text)> &receive,
                         std::span<const std::vector<int>> waits_for = {},
                         const std::function<void(int item, const std::string &how)> &lost = {});

/// Number of workers that cores and memory allow.
/// @param bytes_per_worker  that each of them needs
/// @return >= 1
int workers_that_fit(double bytes_per_worker, const MachineShare &share = share_of_machine());

} // namespace livermark::support
