#include "interactive/kernels/node_rows.hpp"

#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/cuthill_mckee_ordering.hpp>
#include <numeric>

#include "core/mesh/tetra_mesh.hpp"
#include "interactive/kernels/orders.hpp"

namespace livermark::interactive {

namespace {

void put_into_rows(const Field &field, const std::vector<int> &row_of_node, kernels::Aligned<float> &rows) {
    for (Eigen::Index i = 0; i < field.cols(); ++i)
        in_row(rows, row_of_node[i]) = field.col(i).cast<float>();
}

} // namespace

void SimulationInRows::set_state(const Field &positions, const Field &velocities) {
    Simulation::set_state(positions, velocities);
    put_into_rows(positions - rest_, rows().row_of_node, rows().displacement);
    put_into_rows(velocities, rows().row_of_node, rows().velocity);
}

void SimulationInRows::set_external_forces(const Field &forces) {
    Simulation::set_external_forces(forces);
    put_into_rows(external_forces(), rows().row_of_node, rows().external);
}

bool SimulationInRows::touch(const std::shared_ptr<core::BallContact> &ball) {
    ball_ = ball;
    return true;
}

void SimulationInRows::take_state_from_rows() {
    auto &x = mutable_positions();
    for (Eigen::Index i = 0; i < x.cols(); ++i) {
        const int row = rows().row_of_node[i];
        x.col(i) = rest_.col(i) + in_row(rows().displacement, row).cast<double>();
        mutable_velocities().col(i) = in_row(rows().velocity, row).cast<double>();
    }
    move_to_targets();
}

Cost SimulationInRows::cost_of(double element_passes, std::size_t bytes) const {
    return {.element_passes = element_passes,
            .bytes_per_element =
                static_cast<double>(bytes) / static_cast<double>(scene().body->mesh.tetrahedra.size())};
}

namespace kernels {

namespace {

/// Nodes: large enough to find some that are alike, small enough to stay near.
constexpr std::size_t node_window = 256;

std::vector<int> cuthill_mckee(const std::vector<std::array<int, 4>> &tetrahedra, std::size_t num_corners) {
    using Properties = boost::property<boost::vertex_color_t, boost::default_color_type>;
    boost::adjacency_list<boost::vecS, boost::vecS, boost::undirectedS, Properties> graph(num_corners);
    for (const auto &[a, b] : core::edge_table(tetrahedra).edges)
        boost::add_edge(a, b, graph);
    std::vector<int> order(num_corners);
    boost::cuthill_mckee_ordering(graph, order.rbegin(), get(boost::vertex_color, graph),
                                  boost::make_degree_map(graph));
    return order;
}

} // namespace

void NodeRows::place(const Scene &scene, const std::vector<int> &order) {
    row_of_node.resize(order.size());
    for (std::size_t row = 0; row < order.size(); ++row)
        row_of_node[order[row]] = static_cast<int>(row);
    num_rows = filled_up(order.size());
    for (auto *field : {&displacement, &velocity, &external, &inverse_mass})
        field->assign(4 * num_rows, 0.0F);
    const auto is_free = free_nodes(scene);
    for (std::size_t i = 0; i < order.size(); ++i)
        if (is_free[i])
            in_row(inverse_mass, row_of_node[i]).setConstant(static_cast<float>(1.0 / scene.node_mass[i]));
}

std::vector<int> NodeRows::order() const {
    std::vector<int> nodes(row_of_node.size());
    for (std::size_t i = 0; i < row_of_node.size(); ++i)
        nodes[row_of_node[i]] = static_cast<int>(i);
    return nodes;
}

void NodeRows::aim_constrained(const Scene &scene, const Field &rest, const Field &x, const Field &targets,
                               double time_step) {
    const auto aim = [&](int node, const core::Vector3 &target) {
        in_row(displacement, row_of_node[node]) = (x.col(node) - rest.col(node)).cast<float>();
        in_row(velocity, row_of_node[node]) = ((target - x.col(node)) / time_step).cast<float>();
    };
    for (Eigen::Index c = 0; c < targets.cols(); ++c)
        aim(scene.constrained_nodes[c], targets.col(c));
    for (const auto &[node, ends] : scene.followers)
        aim(node, 0.5 * (targets.col(ends[0]) + targets.col(ends[1])));
}

std::vector<int> order_of_nodes(const std::vector<std::array<int, 4>> &tetrahedra,
                                const std::vector<std::array<int, 2>> &ends, const std::vector<int> &num_items,
                                const std::vector<int> &corners) {
    const std::size_t num_corners = num_items.size() - ends.size();
    auto order = corners.size() == num_corners ? corners : cuthill_mckee(tetrahedra, num_corners);
    if (!ends.empty()) {
        std::vector<int> place(num_items.size()); // twice, so that the middle of two is whole
        for (std::size_t k = 0; k < num_corners; ++k)
            place[order[k]] = 2 * static_cast<int>(k);
        for (std::size_t e = 0; e < ends.size(); ++e)
            place[num_corners + e] = (place[ends[e][0]] + place[ends[e][1]]) / 2;
        order.resize(num_items.size());
        std::iota(order.begin(), order.end(), 0);
        std::ranges::stable_sort(order, {}, [&](int node) { return place[node]; });
    }
    sort_in_windows_of(node_window, order, [&](int a, int b) { return num_items[a] > num_items[b]; });
    return order;
}

} // namespace kernels

} // namespace livermark::interactive
