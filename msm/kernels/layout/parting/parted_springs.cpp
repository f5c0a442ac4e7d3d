#include <algorithm>
#include <array>
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
        std::ranges::stable_sort(ends, {}, &SpringEnd::neighbour);
        return ends;
    }

  private:
    const StepParts &parts_;
    const NumberLists &springs_;
};

void forget_places(const SpringLines &lines, const std::vector<SpringEnd> &ends, SlicedPlan &plan) {
    const auto first = static_cast<std::size_t>(lines.first_spring) * 2 * slice_size;
    const auto last = first + static_cast<std::size_t>(lines.count.num_springs()) * 2 * slice_size;
    for (const auto &end : ends)
        for (auto &place : plan.springs[end.spring])
            if (place >= first && place < last)
                place = no_place;
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
    std::set<int> pairs;
    for (const int node : nodes) {
        std::vector<int> springs;
        for (const int s : plan.springs_of_node.of(node))
            if (!std::ranges::binary_search(changes.gone_springs, s))
                springs.push_back(s);
        for (; next != added.end() && next->first == node; ++next)
            springs.push_back(next->second);
        plan.springs_of_node.set(node, springs);
        pairs.insert(body.row_of_node[node] / pair_size);
    }
    const auto num_before = static_cast<int>(body.spring_lines.size());
    body.spring_lines.resize(static_cast<std::size_t>(body.num_slices) / 2);
    const SpringsOfNodes springs(parts, plan.springs_of_node);
    for (const int pair : pairs) {
        auto &lines = body.spring_lines[pair];
        std::vector<SpringLane> lanes;
        for (int lane = 0; lane < slice_size; ++lane) {
            const int row = pair * pair_size + lane;
            const std::array node{plan.node_of_row[row], plan.node_of_row[row + slice_size]};
            const auto first = springs.of(node[0]), second = springs.of(node[1]);
            if (pair < num_before) {
                forget_places(lines, first, plan);
                forget_places(lines, second, plan);
            }
            lanes.push_back(lane_around(node, first, second));
        }
        const auto count = pair < num_before ? enough_lines(lines.count, lanes) : fewest_lines(lanes, 0, lanes.size());
        const bool is_enough = pair < num_before && count.alone == lines.count.alone;
        auto put = is_enough ? PairLines<T>(parts, lines, body, plan) : PairLines<T>(parts, count, body, plan);
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
