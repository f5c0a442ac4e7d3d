#include "msm/kernels/sliced_body.hpp"

#include "msm/kernels/node_order.hpp"
#include "msm/kernels/slicing.hpp"

namespace livermark::msm {

namespace {

template <class T> void slice_springs(const StepParts &parts, SlicedBody<T> &body) {
    std::vector<int> degree(body.first_copy, 0);
    for (const auto &edge : parts.edges)
        for (const int node : edge)
            ++degree[body.row_of_node[node]];
    body.spring_start = starts(degree);
    const std::size_t size = static_cast<std::size_t>(body.spring_start.back()) * slice_size;
    body.neighbour.assign(size, 4 * body.num_rows);
    body.stiffness.assign(size, T(0));
    body.half_pull.assign(size, T(0));
    std::vector<int> used(degree.size(), 0);
    for (std::size_t s = 0; s < parts.edges.size(); ++s)
        for (int end = 0; end < 2; ++end) {
            const int row = body.row_of_node[parts.edges[s][end]];
            const auto at = place(body.spring_start, row, used[row]);
            body.neighbour[at] = 4 * body.row_of_node[parts.edges[s][1 - end]];
            body.stiffness[at] = static_cast<T>(parts.stiffness[s]);
            body.half_pull[at] = static_cast<T>(0.5 * parts.stiffness[s] * parts.rest_length[s]);
        }
}

} // namespace

template <class T> SlicedBody<T> sliced_body(const StepParts &parts, const std::vector<core::Vector3> &positions) {
    SlicedBody<T> body;
    const int num_nodes = static_cast<int>(positions.size());
    const auto order =
        order_by_degree(parts.edges.empty() ? core::edge_table(parts.tetrahedra).edges : parts.edges, num_nodes);
    body.row_of_node.resize(num_nodes);
    for (int row = 0; row < num_nodes; ++row)
        body.row_of_node[order[row]] = row;
    body.first_copy = body.num_rows = padded(num_nodes);
    body.num_slices = body.first_copy / slice_size;
    slice_tetrahedra(parts, positions, body); // finds out how many rows there are
    slice_springs(parts, body);
    return body;
}

template SlicedBody<float> sliced_body(const StepParts &, const std::vector<core::Vector3> &);
template SlicedBody<double> sliced_body(const StepParts &, const std::vector<core::Vector3> &);

} // namespace livermark::msm
