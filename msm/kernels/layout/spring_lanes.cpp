#include "msm/kernels/layout/sliced_body.hpp"

#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/cuthill_mckee_ordering.hpp>
#include <limits>
#include <tuple>

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

} // namespace livermark::msm
