#include "fem_reference/solvers/multigrid/nested_iteration.hpp"

#include <algorithm>

#include "fem_reference/solvers/multivector.hpp"

namespace livermark::fem_reference {

namespace {

constexpr int num_corners = 4;

/// The corners of the fine mesh are the corners of the coarse one, where pressures are the same, and the midpoints of
/// its edges, where they are the mean of both ends.
SparseRows pressure_prolongation(const ElasticSystem &coarse, const PressureSystem &coarse_pressure,
                                 const ElasticSystem &fine, const PressureSystem &fine_pressure,
                                 const Prolongation &displacement, std::span<const int> parent) {
    std::vector<int> coarse_node(fine.points.size(), -1);
    for (std::size_t node = 0; node < displacement.fine_node.size(); ++node)
        coarse_node[displacement.fine_node[node]] = static_cast<int>(node);
    std::vector<std::vector<int>> ends(fine_pressure.num_pressures()); // one or two pressures
    for (std::size_t child = 0; child < fine_pressure.of_cell.size(); ++child) {
        const auto t = static_cast<std::size_t>(parent[child]);
        const auto &pressures = coarse_pressure.of_cell[t];
        if (pressures.front() < 0)
            continue;
        const auto nodes = std::span(coarse.cell_nodes).subspan(t * coarse.nodes_per_cell, coarse.nodes_per_cell);
        for (int corner = 0; corner < num_corners; ++corner) {
            auto &of_corner = ends[fine_pressure.of_cell[child][corner]];
            if (!of_corner.empty())
                continue;
            const int node = coarse_node[fine.cell_nodes[child * fine.nodes_per_cell + corner]];
            const auto local = static_cast<int>(std::ranges::find(nodes, node) - nodes.begin());
            if (local < num_corners) {
                of_corner = {pressures[local]};
            } else {
                const auto [a, b] = edges_of_quadratic[local - num_corners];
                of_corner = {pressures[a], pressures[b]};
            }
        }
    }
    SparseRows result;
    result.row_start.push_back(0);
    for (const auto &of_corner : ends) {
        for (const int pressure : of_corner) {
            result.column.push_back(pressure);
            result.value.push_back(1.0 / static_cast<double>(of_corner.size()));
        }
        result.row_start.push_back(static_cast<int>(result.column.size()));
    }
    return result;
}

} // namespace

std::vector<double> NestedIteration::prolonged_pressure(std::span<const double> coarse, int lanes) const {
    const std::size_t num_rows = pressure.row_start.size() - 1;
    std::vector<double> fine(lanes * num_rows, 0.0);
    for (std::size_t row = 0; row < num_rows; ++row)
        for (int k = pressure.row_start[row]; k < pressure.row_start[row + 1]; ++k)
            for (int c = 0; c < lanes; ++c)
                fine[lanes * row + c] +=
                    pressure.value[k] * coarse[static_cast<std::size_t>(lanes) * pressure.column[k] + c];
    return fine;
}

NestedIteration nested_iteration(const ElasticSystem &coarse, const PressureSystem &coarse_pressure,
                                 const ElasticSystem &fine, const PressureSystem &fine_pressure,
                                 std::span<const int> parent) {
    auto displacement = prolongation(coarse, fine, parent);
    const auto by_number = parent.empty() ? parents_by_number(coarse, fine) : std::vector<int>{};
    auto pressure = pressure_prolongation(coarse, coarse_pressure, fine, fine_pressure, displacement,
                                          parent.empty() ? by_number : parent);
    return {std::move(displacement), std::move(pressure)};
}

} // namespace livermark::fem_reference
