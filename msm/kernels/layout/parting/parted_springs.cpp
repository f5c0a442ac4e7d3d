#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "msm/kernels/layout/pair_lines.hpp"
#include "msm/kernels/layout/parting/parting.hpp"

namespace livermark::msm {

namespace {

/// More lines for nodes alone, until lanes have all of their neighbours there.
LineCounts enough_lines(LineCounts count, const std::vector<SpringLane> &lanes) {
    for (const auto &lane : lanes) {
        const int used = std::min(static_cast<int>(lane.shared.size()), count.shared);
        const int split = static_cast<int>(lane.shared.size()) - used;
        std::array<int, 2> beyond{};
        for (const std::size_t side : {0, 1})
            beyond[side] = std::max(0, static_cast<int>(lane.alone[side].size()) + split - count.alone[side]);
        int lacking = used + beyond[0] + beyond[1] - count.shared;
        for (const std::size_t side : {0, 1}) {
            const int more = std::clamp(lacking, 0, beyond[side]);
            count.alone[side] += more;
            lacking -= more;
        }
    }
    return count;
}

class SpringsOfNodes {
  public:
    SpringsOfNodes(const StepParts &parts, const NumberLists &springs) : parts_(parts), springs_(springs) {}

    /// By rising neighbour.
    std::vector<SpringEnd> of(int node) const {
        std::vector<SpringEnd> ends;
        if (node == padding)
            return ends;
        for (const int s : springs_.of(node)) {
            const auto [i, j] = parts_.edges[s];
            ends.push_back({i == node ? j : i, s});
        }
        std::ranges::sort(ends, {}, &SpringEnd::neighbour);
        return ends;
    }

  private:
    const StepParts &parts_;
    const NumberLists &springs_;
};

/// A spring may end in another lane of the pair too: it stays there.
void forget_places(const SpringLines &lines, int lane, const std::vector<SpringEnd> &ends, SlicedPlan &plan) {
    const auto first = static_cast<std::size_t>(lines.first_spring) * 2 * slice_size;
    const auto last = first + static_cast<std::size_t>(lines.count.num_springs()) * 2 * slice_size;
    for (const auto &end : ends)
        for (auto &place : plan.springs[end.spring])
            if (place >= first && place < last && place % slice_size == static_cast<std::size_t>(lane))
                place = no_place;
}

/// A lane with its springs as they are now, whose places in its pair of slices are forgotten.
/// @param lines  of the pair; null if it has none yet
SpringLane take_lane(int pair, int lane, const SpringLines *lines, const SpringsOfNodes &springs, SlicedPlan &plan) {
    const int row = pair * pair_size + lane;
    const std::array node{plan.node_of_row[row], plan.node_of_row[row + slice_size]};
    const auto first = springs.of(node[0]), second = springs.of(node[1]);
    if (lines) {
        forget_places(*lines, lane, first, plan);
        forget_places(*lines, lane, second, plan);
    }
    return lane_around(node, first, second);
}

} // namespace

template <class T>
void part_springs(const StepParts &parts, const PartingChanges &changes, SlicedPlan &plan, SlicedBody<T> &body) {
    if (parts.edges.empty())
        return;
    std::set<int> nodes; // that have lost a spring or got one
    for (const int s : changes.gone_springs) {
        plan.springs[s] = {no_place, no_place};
        nodes.insert(parts.edges[s].begin(), parts.edges[s].end());
    }
    plan.springs.resize(parts.edges.size(), {no_place, no_place});
    plan.springs_of_node.resize(body.row_of_node.size());
    std::vector<std::pair<int, int>> added; // node, spring
    for (auto s = static_cast<std::size_t>(changes.first_new_spring); s < parts.edges.size(); ++s)
        for (const int node : parts.edges[s]) {
            nodes.insert(node);
            added.emplace_back(node, static_cast<int>(s));
        }
    std::ranges::sort(added);
    auto next = added.begin();
    std::map<int, std::set<int>> touched; // lanes of each pair
    for (const int node : nodes) {
        std::vector<int> springs;
        for (const int s : plan.springs_of_node.of(node))
            if (!std::ranges::binary_search(changes.gone_springs, s))
                springs.push_back(s);
        for (; next != added.end() && next->first == node; ++next)
            springs.push_back(next->second);
        plan.springs_of_node.set(node, springs);
        const int row = body.row_of_node[node];
        touched[row / pair_size].insert(row % slice_size);
    }
    const auto num_before = static_cast<int>(body.spring_lines.size());
    body.spring_lines.resize(static_cast<std::size_t>(body.num_slices) / 2);
    const SpringsOfNodes springs(parts, plan.springs_of_node);
    for (const auto &[pair, changed] : touched) {
        auto &lines = body.spring_lines[pair];
        const auto *lines_before = pair < num_before ? &lines : nullptr;
        std::vector<SpringLane> lanes;
        for (const int lane : changed)
            lanes.push_back(take_lane(pair, lane, lines_before, springs, plan));
        auto count = lines.count;
        if (pair < num_before) {
            count = enough_lines(count, lanes);
            if (count.alone == lines.count.alone) {
                PairLines<T> put(parts, lines, body, plan);
                for (const int lane : changed)
                    put.clear(lane);
                for (std::size_t l = 0; const int lane : changed)
                    put.fill(lane, lanes[l++]);
                continue;
            }
        }
        lanes.clear();
        for (int lane = 0; lane < slice_size; ++lane)
            lanes.push_back(take_lane(pair, lane, lines_before, springs, plan));
        if (pair >= num_before)
            count = fewest_lines(lanes, 0, lanes.size());
        PairLines<T> put(parts, count, body, plan);
        for (int lane = 0; lane < slice_size; ++lane)
            put.fill(lane, lanes[lane]);
        lines = put.lines();
    }
    for (const int s : changes.springs)
        for (const auto place : plan.springs[s])
            if (place != no_place)
                put_spring(parts, s, place, body);
}

template void part_springs(const StepParts &, const PartingChanges &, SlicedPlan &, SlicedBody<float> &);
template void part_springs(const StepParts &, const PartingChanges &, SlicedPlan &, SlicedBody<double> &);

} // namespace livermark::msm
