#include "fem_reference/linear/place_weights.hpp"

#include <array>

namespace livermark::fem_reference {

namespace {

constexpr int corners_per_cell = 4, nodes_of_quadratic_cell = 10;

/// The ends of the edges whose midpoints follow the corners in ElasticSystem::cell_nodes.
constexpr std::array<std::array<int, 2>, 6> edges_of_cell{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

/// Lagrange's shape functions at a point, the first nodes_per_cell of them.
std::array<double, nodes_of_quadratic_cell> shape_functions(const Eigen::Vector4d &at, int nodes_per_cell) {
    std::array<double, nodes_of_quadratic_cell> values{};
    for (int i = 0; i < corners_per_cell; ++i)
        values[i] = nodes_per_cell == corners_per_cell ? at[i] : at[i] * (2.0 * at[i] - 1.0);
    if (nodes_per_cell != corners_per_cell)
        for (std::size_t e = 0; e < edges_of_cell.size(); ++e)
            values[corners_per_cell + e] = 4.0 * at[edges_of_cell[e][0]] * at[edges_of_cell[e][1]];
    return values;
}

} // namespace

Eigen::SparseMatrix<double, Eigen::RowMajor> place_weights(std::span<const core::InteriorPlace> places,
                                                           const ElasticSystem &system, const core::TetraMesh &mesh) {
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t k = 0; k < places.size(); ++k)
        for (const auto &[tetrahedron, barycentric, weight] : core::points_of(places[k], mesh)) {
            const auto shape = shape_functions(barycentric, system.nodes_per_cell);
            for (int a = 0; a < system.nodes_per_cell; ++a)
                entries.emplace_back(static_cast<int>(k), system.cell_nodes[tetrahedron * system.nodes_per_cell + a],
                                     weight * shape[a]);
        }
    Eigen::SparseMatrix<double, Eigen::RowMajor> weights(static_cast<Eigen::Index>(places.size()), system.num_nodes());
    weights.setFromTriplets(entries.begin(), entries.end());
    return weights;
}

std::vector<double> load_of(const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights, Eigen::Index place, int axis) {
    std::vector<double> load(3 * weights.cols(), 0.0);
    for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(weights, place); entry; ++entry)
        load[3 * entry.col() + axis] = entry.value();
    return load;
}

} // namespace livermark::fem_reference
