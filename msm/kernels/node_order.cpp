#include "msm/kernels/node_order.hpp"

#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/cuthill_mckee_ordering.hpp>

namespace livermark::msm {

namespace {

/// Large enough to find equals, small enough to stay near: 256 positions are 4 kB.
constexpr std::size_t window = 256;

using Graph = boost::adjacency_list<
    boost::vecS, boost::vecS, boost::undirectedS,
    boost::property<boost::vertex_color_t, boost::default_color_type, boost::property<boost::vertex_degree_t, int>>>;

} // namespace

std::vector<int> neighbourly_order(int num_nodes, const std::vector<std::array<int, 2>> &edges) {
    Graph graph(num_nodes);
    for (const auto &[i, j] : edges)
        boost::add_edge(i, j, graph);
    std::vector<Graph::vertex_descriptor> reversed;
    boost::cuthill_mckee_ordering(graph, std::back_inserter(reversed), boost::get(boost::vertex_color, graph),
                                  boost::make_degree_map(graph));
    std::vector<int> order(reversed.rbegin(), reversed.rend());
    for (std::size_t first = 0; first < order.size(); first += window) {
        const auto begin = order.begin() + static_cast<std::ptrdiff_t>(first);
        const auto end = order.begin() + static_cast<std::ptrdiff_t>(std::min(first + window, order.size()));
        std::stable_sort(begin, end, [&](int a, int b) { return boost::degree(a, graph) > boost::degree(b, graph); });
    }
    return order;
}

} // namespace livermark::msm
