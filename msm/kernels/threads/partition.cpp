#include "msm/kernels/threads/partition.hpp"

#include <algorithm>
#include <set>

namespace livermark::msm {

namespace {

/// Cuts what has the given running costs into parts of about equal cost.
std::vector<Partition> partitions(const std::vector<int> &running_cost, int num_threads) {
    std::vector<Partition> parts(num_threads);
    const int total = running_cost.empty() ? 0 : running_cost.back();
    const auto cut = [&](int part) {
        const auto wanted = static_cast<int>(static_cast<long>(total) * part / num_threads);
        return static_cast<int>(std::ranges::lower_bound(running_cost, wanted) - running_cost.begin());
    };
    for (int thread = 0; thread < num_threads; ++thread)
        parts[thread] = {cut(thread), cut(thread + 1)};
    parts.front().first = 0;
    parts.back().last = std::max(static_cast<int>(running_cost.size()) - 1, 0);
    return parts;
}

/// The pairs of slices of a thread, those last that read rows of other threads. The forces of tetrahedra have barriers
/// of their own, and all nodes may be read by the fans of others.
template <class T> PairPartition partition_of_pairs(const SlicedBody<T> &body, const Partition &part) {
    PairPartition result;
    for (int pair = part.first; pair < part.last; ++pair)
        result.order.push_back(pair);
    if (!body.rest_volume.empty() || body.spring_lines.empty())
        return result;
    constexpr int line_size = 64 / sizeof(T);
    std::set<int> ghost;
    const auto is_interior = [&](int pair) {
        bool is = true;
        const auto &lines = body.spring_lines[pair];
        const auto first = body.neighbour.begin() + static_cast<std::ptrdiff_t>(lines.first_neighbour) * slice_size;
        const auto last = first + static_cast<std::ptrdiff_t>(lines.count.total()) * slice_size;
        for (auto index = first; index != last; ++index) {
            const int other = *index / 4 / pair_size;
            if (2 * other >= body.num_slices || (other >= part.first && other < part.last))
                continue;
            ghost.insert(*index / line_size * line_size);
            is = false;
        }
        return is;
    };
    const auto first_shared = std::stable_partition(result.order.begin(), result.order.end(), is_interior);
    result.num_interior = static_cast<std::size_t>(first_shared - result.order.begin());
    result.ghost.index.assign(ghost.begin(), ghost.end());
    for (auto pair = first_shared; pair != result.order.end(); ++pair)
        for (int index = 0; index < 4 * pair_size; index += line_size)
            result.shared.index.push_back(4 * pair_size * *pair + index);
    for (auto *lines : {&result.ghost, &result.shared})
        lines->at_once = lines->index.size() / std::max<std::size_t>(1, result.num_interior / 2) + 1;
    return result;
}

/// What it takes to move the pairs of slices before each one: to fetch a line of neighbours takes about as long as the
/// forces of a line of springs, and where there are no springs, nodes cost what it takes to collect the forces of
/// tetrahedra.
template <class T> std::vector<int> running_cost_of_pairs(const SlicedBody<T> &body) {
    std::vector<int> cost;
    if (!body.spring_lines.empty())
        cost.push_back(0);
    for (const auto &lines : body.spring_lines)
        cost.push_back(cost.back() + lines.count.total() + lines.count.num_springs());
    if (cost.empty())
        for (int slice = 0; slice <= body.num_slices; slice += 2)
            cost.push_back(body.sum_start[slice]);
    return cost;
}

/// Of things that cost the same.
std::vector<int> running_count(int count) {
    std::vector<int> cost;
    for (int i = 0; i <= count; ++i)
        cost.push_back(i);
    return cost;
}

} // namespace

template <class T> void partition_work(StepWorkspace<T> &workspace, int num_threads) {
    const auto &body = workspace.body;
    for (const auto &part : partitions(running_cost_of_pairs(body), num_threads))
        workspace.pairs.push_back(partition_of_pairs(body, part));
    workspace.fan_slices = partitions(body.fan_start, num_threads);
    workspace.chunks = partitions(running_count(static_cast<int>(body.chunk_start.size()) - 1), num_threads);
    workspace.volume_slices = partitions(body.mean_start.empty() ? body.volume_start : body.mean_start, num_threads);
}

template void partition_work(StepWorkspace<float> &, int);
template void partition_work(StepWorkspace<double> &, int);

} // namespace livermark::msm
