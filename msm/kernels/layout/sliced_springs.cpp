#include <algorithm>
#include <array>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/cuthill_mckee_ordering.hpp>
#include <cstddef>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "msm/kernels/layout/slicing.hpp"

namespace livermark::msm {

namespace {

/// Large enough to find equals, small enough to stay near: 256 positions are 4 kB.
constexpr std::size_t row_window = 256;

} // namespace

std::vector<int> reverse_cuthill_mckee(std::span<const std::array<int, 2>> edges, int num_nodes) {
    using Properties = boost::property<boost::vertex_color_t, boost::default_color_type>;
    using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::undirectedS, Properties>;
    Graph graph(num_nodes);
    for (const auto &[i, j] : edges)
        boost::add_edge(i, j, graph);
    std::vector<int> order(num_nodes);
    boost::cuthill_mckee_ordering(graph, order.rbegin(), get(boost::vertex_color, graph),
                                  boost::make_degree_map(graph));
    return order;
}

std::vector<int> order_by_degree(std::span<const std::array<int, 2>> edges, int num_nodes) {
    auto order = reverse_cuthill_mckee(edges, num_nodes);
    std::vector<int> degree(num_nodes, 0);
    for (const auto &edge : edges)
        for (const int node : edge)
            ++degree[node];
    sort_in_windows(order, row_window, [&](int a, int b) { return degree[a] > degree[b]; });
    return order;
}

namespace {

/// Lanes, 256 nodes as elsewhere: large enough to find some that are alike, small enough to stay near.
constexpr std::size_t lane_window = 128;

/// Springs at each node, by rising neighbour.
std::vector<std::vector<SpringEnd>> spring_ends(const std::vector<std::array<int, 2>> &edges, int num_nodes) {
    std::vector<std::vector<SpringEnd>> ends(num_nodes);
    for (std::size_t s = 0; s < edges.size(); ++s)
        for (int end = 0; end < 2; ++end)
            ends[edges[s][end]].push_back({edges[s][1 - end], static_cast<int>(s)});
    for (auto &node_ends : ends)
        std::ranges::stable_sort(node_ends, {}, &SpringEnd::neighbour);
    return ends;
}

/// Calls visit(neighbour, springs) for what is around two nodes, with both springs where it is shared.
template <class Visit>
void visit_both(const std::vector<SpringEnd> &a, const std::vector<SpringEnd> &b, const Visit &visit) {
    auto x = a.begin(), y = b.begin();
    while (x != a.end() || y != b.end()) {
        const int from_a = x == a.end() ? std::numeric_limits<int>::max() : x->neighbour;
        const int from_b = y == b.end() ? std::numeric_limits<int>::max() : y->neighbour;
        const int neighbour = std::min(from_a, from_b);
        visit(LaneNeighbour{neighbour,
                            {from_a == neighbour ? (x++)->spring : -1, from_b == neighbour ? (y++)->spring : -1}});
    }
}

/// The other node of each one's pair, -1 where none is left.
std::vector<int> mates(const std::vector<std::array<int, 2>> &edges, const std::vector<std::vector<SpringEnd>> &ends,
                       const std::vector<int> &order) {
    std::vector<int> place(order.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        place[order[k]] = static_cast<int>(k);
    std::vector<std::tuple<int, int, int>> candidates; // fewest that are not shared, first in order, edge
    for (std::size_t s = 0; s < edges.size(); ++s) {
        const auto [i, j] = edges[s];
        int num_shared = 0;
        visit_both(ends[i], ends[j], [&](const LaneNeighbour &n) { num_shared += n.is_shared(); });
        candidates.emplace_back(-num_shared, std::min(place[i], place[j]), static_cast<int>(s));
    }
    std::ranges::sort(candidates);
    std::vector<int> mate(order.size(), -1);
    for (const auto &candidate : candidates) {
        const auto [i, j] = edges[std::get<2>(candidate)];
        if (i != j && mate[i] < 0 && mate[j] < 0) {
            mate[i] = j;
            mate[j] = i;
        }
    }
    return mate;
}

SpringLane lane_of(int first, int second, const std::vector<std::vector<SpringEnd>> &ends) {
    static const std::vector<SpringEnd> nobody;
    auto lane = lane_around({first, second}, ends[first], second < 0 ? nobody : ends[second]);
    if (lane.alone[0].size() < lane.alone[1].size()) {
        std::swap(lane.node[0], lane.node[1]);
        std::swap(lane.alone[0], lane.alone[1]);
        for (auto *list : {&lane.shared, &lane.alone[0], &lane.alone[1]})
            for (auto &n : *list)
                std::swap(n.spring[0], n.spring[1]);
    }
    return lane;
}

} // namespace

SpringLane lane_around(const std::array<int, 2> &nodes, const std::vector<SpringEnd> &at_first,
                       const std::vector<SpringEnd> &at_second) {
    SpringLane lane;
    lane.node = nodes;
    const auto between = std::ranges::find(at_first, nodes[1], &SpringEnd::neighbour);
    if (between != at_first.end())
        lane.between = between->spring;
    visit_both(at_first, at_second, [&](const LaneNeighbour &n) {
        if (lane.between >= 0 && std::ranges::count(n.spring, lane.between) > 0)
            return; // seen from either end
        if (n.is_shared())
            lane.shared.push_back(n);
        else
            lane.alone[n.spring[0] >= 0 ? 0 : 1].push_back(n);
    });
    return lane;
}

std::vector<SpringLane> spring_lanes(const StepParts &parts, int num_nodes) {
    const auto order = reverse_cuthill_mckee(parts.edges, num_nodes);
    const auto ends = spring_ends(parts.edges, num_nodes);
    const auto mate = mates(parts.edges, ends, order);
    std::vector<SpringLane> lanes;
    std::vector<char> is_taken(num_nodes, 0);
    int waiting = -1; // a node without a mate
    const auto add = [&](int first, int second) {
        lanes.push_back(lane_of(first, second, ends));
        is_taken[first] = 1;
        if (second >= 0)
            is_taken[second] = 1;
    };
    for (const int node : order) {
        if (is_taken[node])
            continue;
        if (mate[node] >= 0) {
            add(node, mate[node]);
        } else if (waiting < 0) {
            waiting = node;
        } else {
            add(waiting, node);
            waiting = -1;
        }
    }
    if (waiting >= 0)
        add(waiting, -1);
    sort_in_windows(lanes, lane_window, [](const SpringLane &a, const SpringLane &b) {
        return std::pair(a.num_neighbours(), a.shared.size()) > std::pair(b.num_neighbours(), b.shared.size());
    });
    return lanes;
}

LineCounts fewest_lines(const std::vector<SpringLane> &lanes, std::size_t first, std::size_t last) {
    int most = 0;
    for (std::size_t l = first; l < last; ++l)
        most = std::max(most, static_cast<int>(lanes[l].num_neighbours()));
    // To fetch a line of neighbours takes about as long as the forces of a line of springs.
    const auto cost = [](const LineCounts &c) { return c.total() + c.num_springs(); };
    LineCounts best{most, {}};
    for (int shared = 0; shared <= most; ++shared)
        for (int alone = 0; alone <= most; ++alone) {
            LineCounts counts{shared, {alone, 0}};
            bool is_enough = true;
            for (std::size_t l = first; l < last && is_enough; ++l) {
                const int split = std::max(0, static_cast<int>(lanes[l].shared.size()) - shared);
                const int room = std::max(0, shared - static_cast<int>(lanes[l].shared.size()));
                const int left = room - std::max(0, static_cast<int>(lanes[l].alone[0].size()) + split - alone);
                is_enough = left >= 0;
                counts.alone[1] = std::max(counts.alone[1], static_cast<int>(lanes[l].alone[1].size()) + split - left);
            }
            if (is_enough && cost(counts) < cost(best))
                best = counts;
        }
    return best;
}

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
