#include "msm/kernels/layout/node_order.hpp"

#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/cuthill_mckee_ordering.hpp>

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

} // namespace livermark::msm
