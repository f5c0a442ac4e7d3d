#include "msm/kernels/layout/sliced_body.hpp"

#include <utility>

#include "msm/kernels/layout/node_order.hpp"
#include "msm/kernels/layout/slicing.hpp"

namespace livermark::msm {

namespace {

/// @return shape (N)
std::vector<int> rows_of_lanes(const std::vector<SpringLane> &lanes, int num_nodes) {
    std::vector<int> row(num_nodes);
    for (std::size_t l = 0; l < lanes.size(); ++l)
        for (const int side : {0, 1})
            if (const int node = lanes[l].node[side]; node != padding)
                row[node] =
                    static_cast<int>(l / slice_size) * pair_size + side * slice_size + static_cast<int>(l % slice_size);
    return row;
}

/// @return shape (N)
std::vector<int> rows_by_degree(const StepParts &parts, int num_nodes) {
    const auto order = order_by_degree(core::edge_table(parts.tetrahedra).edges, num_nodes);
    std::vector<int> row(num_nodes);
    for (int r = 0; r < num_nodes; ++r)
        row[order[r]] = r;
    return row;
}

} // namespace

template <class T>
SlicedBody<T> sliced_body(const StepParts &parts, const std::vector<core::Vector3> &positions, SlicedPlan *told) {
    SlicedBody<T> body;
    SlicedPlan plan;
    const int num_nodes = static_cast<int>(positions.size());
    const bool has_springs = !parts.edges.empty();
    const auto lanes = has_springs ? spring_lanes(parts, num_nodes) : std::vector<SpringLane>();
    body.row_of_node = has_springs ? rows_of_lanes(lanes, num_nodes) : rows_by_degree(parts, num_nodes);
    body.first_copy = body.num_rows =
        has_springs ? padded(2 * static_cast<int>(lanes.size()), pair_size) : padded(num_nodes, pair_size);
    body.num_slices = body.first_copy / slice_size;
    slice_tetrahedra(parts, positions, body, plan); // finds out how many rows there are
    slice_springs(parts, lanes, body, plan);
    if (told) {
        plan.node_of_row.assign(static_cast<std::size_t>(body.first_copy), padding);
        for (int node = 0; node < num_nodes; ++node)
            plan.node_of_row[body.row_of_node[node]] = node;
        plan.springs_of_node = NumberLists(parts.edges, positions.size());
    }
    if (told)
        *told = std::move(plan);
    return body;
}

template SlicedBody<float> sliced_body(const StepParts &, const std::vector<core::Vector3> &, SlicedPlan *);
template SlicedBody<double> sliced_body(const StepParts &, const std::vector<core::Vector3> &, SlicedPlan *);

} // namespace livermark::msm
