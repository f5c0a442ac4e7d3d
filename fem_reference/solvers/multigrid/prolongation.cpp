#include "fem_reference/solvers/multigrid/prolongation.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "fem_reference/solvers/multivector.hpp"

namespace livermark::fem_reference {

namespace {

constexpr int num_children = 8;
constexpr int nodes_of_linear = 4;
constexpr int nodes_of_quadratic = 10;
constexpr const char *no_pair =
    "the fine system is not the quadratic one of the same body or of parts of its tetrahedra";

/// Shape functions in the order of ElasticSystem::cell_nodes; those of linear elements are zero from the fifth on.
std::array<double, nodes_of_quadratic> shape_functions(const Eigen::Vector4d &bary, int nodes_per_cell) {
    std::array<double, nodes_of_quadratic> shape{};
    if (nodes_per_cell == nodes_of_linear) {
        std::copy_n(bary.data(), nodes_of_linear, shape.data());
        return shape;
    }
    for (int v = 0; v < 4; ++v)
        shape[v] = bary[v] * (2.0 * bary[v] - 1.0);
    for (std::size_t e = 0; e < edges_of_quadratic.size(); ++e)
        shape[4 + e] = 4.0 * bary[edges_of_quadratic[e][0]] * bary[edges_of_quadratic[e][1]];
    return shape;
}

/// Nodes of the fine system lie at quarters of the edges: rounding makes the coordinates exact.
/// @param inverse  of the matrix of the edge vectors from the first corner
Eigen::Vector4d barycentric(const Eigen::Matrix3d &inverse, const core::Vector3 &from_first_corner) {
    constexpr double parts = 4.0;
    constexpr double largest_rounding = 1e-6;
    const core::Vector3 exact = parts * (inverse * from_first_corner);
    const core::Vector3 rounded = exact.array().round();
    if (!((exact - rounded).cwiseAbs().maxCoeff() < largest_rounding) || rounded.minCoeff() < 0.0 ||
        rounded.sum() > parts)
        throw std::invalid_argument(no_pair);
    const core::Vector3 others = rounded / parts;
    return {1.0 - others.sum(), others[0], others[1], others[2]};
}

template <class T> void add(const Prolongation &p, std::span<const T> coarse, std::span<T> fine) {
    with_lanes(static_cast<int>(coarse.size() / (3 * p.fine_node.size())), [&]<int lanes>() {
        constexpr std::size_t width = 3 * lanes;
        for (std::size_t node = 0; node + 1 < p.row_start.size(); ++node)
            for (int k = p.row_start[node]; k < p.row_start[node + 1]; ++k)
                for (std::size_t i = 0; i < width; ++i)
                    fine[width * node + i] += static_cast<T>(p.weight[k]) * coarse[width * p.coarse_node[k] + i];
    });
}

template <class T> void gather(const Prolongation &p, std::span<const T> fine, std::span<T> coarse) {
    std::ranges::fill(coarse, T(0));
    with_lanes(static_cast<int>(coarse.size() / (3 * p.fine_node.size())), [&]<int lanes>() {
        constexpr std::size_t width = 3 * lanes;
        for (std::size_t node = 0; node + 1 < p.row_start.size(); ++node)
            for (int k = p.row_start[node]; k < p.row_start[node + 1]; ++k)
                for (std::size_t i = 0; i < width; ++i)
                    coarse[width * p.coarse_node[k] + i] += static_cast<T>(p.weight[k]) * fine[width * node + i];
    });
}

} // namespace

std::vector<int> parents_by_number(const ElasticSystem &coarse, const ElasticSystem &fine) {
    const int children = coarse.nodes_per_cell == nodes_of_linear ? 1 : num_children;
    const auto num_coarse = coarse.cell_nodes.size() / coarse.nodes_per_cell;
    std::vector<int> parent(fine.cell_nodes.size() / fine.nodes_per_cell);
    if (parent.size() != children * num_coarse)
        throw std::invalid_argument(no_pair);
    for (std::size_t child = 0; child < parent.size(); ++child)
        parent[child] = static_cast<int>(child) / children;
    return parent;
}

Prolongation prolongation(const ElasticSystem &coarse, const ElasticSystem &fine, std::span<const int> parent) {
    const int nodes_per_cell = coarse.nodes_per_cell;
    const auto by_number = parent.empty() ? parents_by_number(coarse, fine) : std::vector<int>{};
    if (parent.empty())
        parent = by_number;
    if (fine.nodes_per_cell != nodes_of_quadratic || fine.cell_nodes.size() != parent.size() * nodes_of_quadratic)
        throw std::invalid_argument(no_pair);
    std::vector<std::array<double, nodes_of_quadratic>> shape(fine.points.size());
    std::vector<int> cell(fine.points.size(), -1);
    for (std::size_t child = 0; child < parent.size(); ++child) {
        const int *const corners = coarse.cell_nodes.data() + static_cast<std::size_t>(parent[child]) * nodes_per_cell;
        const auto &origin = coarse.points[corners[0]];
        Eigen::Matrix3d edges;
        for (int d = 0; d < 3; ++d)
            edges.col(d) = coarse.points[corners[d + 1]] - origin;
        const Eigen::Matrix3d inverse = edges.inverse();
        for (int k = 0; k < nodes_of_quadratic; ++k) {
            const int node = fine.cell_nodes[child * nodes_of_quadratic + k];
            if (cell[node] >= 0)
                continue;
            cell[node] = parent[child];
            shape[node] = shape_functions(barycentric(inverse, fine.points[node] - origin), nodes_per_cell);
        }
    }

    Prolongation result;
    result.fine_node.assign(coarse.points.size(), -1);
    result.row_start.push_back(0);
    for (std::size_t node = 0; node < shape.size(); ++node) {
        for (int a = 0; a < nodes_per_cell; ++a) {
            const double weight = shape[node][a];
            if (weight == 0.0)
                continue;
            const int coarse_node = coarse.cell_nodes[cell[node] * nodes_per_cell + a];
            result.coarse_node.push_back(coarse_node);
            result.weight.push_back(weight);
            if (weight == 1.0)
                result.fine_node[coarse_node] = static_cast<int>(node);
        }
        result.row_start.push_back(static_cast<int>(result.weight.size()));
    }
    if (std::ranges::count(result.fine_node, -1) > 0)
        throw std::invalid_argument(no_pair);
    return result;
}

void Prolongation::add_prolonged(std::span<const double> coarse, std::span<double> fine) const {
    add(*this, coarse, fine);
}

void Prolongation::add_prolonged(std::span<const float> coarse, std::span<float> fine) const {
    add(*this, coarse, fine);
}

void Prolongation::restrict_to(std::span<const double> fine, std::span<double> coarse) const {
    gather(*this, fine, coarse);
}

void Prolongation::restrict_to(std::span<const float> fine, std::span<float> coarse) const {
    gather(*this, fine, coarse);
}

} // namespace livermark::fem_reference
