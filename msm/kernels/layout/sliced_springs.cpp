#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "msm/kernels/layout/slicing.hpp"

namespace livermark::msm {

/// Fills up the lines of a pair of slices, at the end of which they are.
template <class T> class PairLines {
  public:
    /// On new lines behind those that are there.
    PairLines(const StepParts &parts, const LineCounts &count, SlicedBody<T> &body, SlicedPlan &plan)
        : parts_(parts), body_(body), plan_(plan) {
        lines_ = {static_cast<int>(body.neighbour.size()) / slice_size,
                  static_cast<int>(body.spring.size()) / (2 * slice_size), count};
        body.neighbour.resize(body.neighbour.size() + static_cast<std::size_t>(count.total()) * slice_size,
                              4 * body.num_rows);
        body.spring.resize(body.spring.size() + static_cast<std::size_t>(count.num_springs()) * 2 * slice_size, T(0));
    }

    /// On the lines of a pair that is there.
    PairLines(const StepParts &parts, const SpringLines &lines, SlicedBody<T> &body, SlicedPlan &plan)
        : parts_(parts), body_(body), plan_(plan), lines_(lines) {}

    /// Takes the springs of a lane from its lines.
    void clear(int lane) {
        for (int line = 0; line < lines_.count.total(); ++line)
            body_.neighbour[static_cast<std::size_t>(lines_.first_neighbour + line) * slice_size + lane] =
                4 * body_.num_rows;
        const std::size_t num_springs = 2 * static_cast<std::size_t>(lines_.count.num_springs()); // k, and k l0 / 2
        for (std::size_t line = 0; line < num_springs; ++line)
            body_.spring[(2 * static_cast<std::size_t>(lines_.first_spring) + line) * slice_size + lane] = T(0);
    }

    const SpringLines &lines() const { return lines_; }

    void fill(int number, const SpringLane &lane) {
        const auto &count = lines_.count;
        put_spring(lines_.first_spring, number, lane.between);
        int used = 0; // shared lines
        auto alone = lane.alone;
        for (const auto &n : lane.shared)
            if (used < count.shared) {
                put_shared(used++, number, n);
            } else {
                alone[0].push_back({n.node, {n.spring[0], padding}});
                alone[1].push_back({n.node, {padding, n.spring[1]}});
            }
        int line = count.shared, spring_line = lines_.first_spring + 1 + 2 * count.shared;
        for (const int side : {0, 1}) {
            for (std::size_t k = 0; k < alone[side].size(); ++k) {
                const auto &n = alone[side][k];
                const int own_line = static_cast<int>(k);
                if (own_line >= count.alone[side]) {
                    put_shared(used++, number, n);
                    continue;
                }
                put_neighbour(line + own_line, number, n.node);
                put_spring(spring_line + own_line, number, n.spring[side]);
            }
            line += count.alone[side];
            spring_line += count.alone[side];
        }
    }

  private:
    void put_shared(int line, int number, const LaneNeighbour &neighbour) {
        put_neighbour(line, number, neighbour.node);
        for (const int side : {0, 1})
            put_spring(lines_.first_spring + 1 + 2 * line + side, number, neighbour.spring[side]);
    }
    void put_neighbour(int line, int number, int node) {
        const std::size_t at = static_cast<std::size_t>(lines_.first_neighbour + line) * slice_size;
        body_.neighbour[at + number] = 4 * body_.row_of_node[node];
    }
    void put_spring(int line, int number, int spring) {
        if (spring == padding)
            return;
        const std::size_t at = static_cast<std::size_t>(line) * 2 * slice_size + number;
        msm::put_spring(parts_, spring, at, body_);
        auto &[first, last] = plan_.springs[spring];
        (first == no_place ? first : last) = at;
        if (last == no_place)
            last = at;
    }

    const StepParts &parts_;
    SlicedBody<T> &body_;
    SlicedPlan &plan_;
    SpringLines lines_;
};

template <class T>
void slice_springs(const StepParts &parts, const std::vector<SpringLane> &lanes, SlicedBody<T> &body,
                   SlicedPlan &plan) {
    plan.springs.assign(parts.edges.size(), {no_place, no_place});
    for (std::size_t first = 0; first < lanes.size(); first += slice_size) {
        const std::size_t last = std::min(first + slice_size, lanes.size());
        PairLines<T> lines(parts, fewest_lines(lanes, first, last), body, plan);
        for (std::size_t l = first; l < last; ++l)
            lines.fill(static_cast<int>(l - first), lanes[l]);
        body.spring_lines.push_back(lines.lines());
    }
}

template void slice_springs(const StepParts &, const std::vector<SpringLane> &, SlicedBody<float> &, SlicedPlan &);
template void slice_springs(const StepParts &, const std::vector<SpringLane> &, SlicedBody<double> &, SlicedPlan &);

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
