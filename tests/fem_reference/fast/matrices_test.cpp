#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <set>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/matrices.hpp"
#include "fem_reference/solvers/two_level.hpp"
#include "tests/fem_reference/dense_divergence.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"

namespace livermark {
namespace {

core::Body box_body() {
    core::Body body;
    body.mesh = tests::shaken_box_mesh({0.1, 0.08, 0.06}, {3, 2, 2});
    body.materials = {{1060.0, 5000.0, 0.4}};
    return body;
}

/// Quadratic elements on a shaken box: rows of all lengths.
fem_reference::ElasticSystem box_system() {
    return fem_reference::assemble(box_body(), 2);
}

Eigen::MatrixXd dense(const fem_reference::SymmetricBlocks<double> &matrix) {
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(matrix.num_rows(), matrix.num_rows());
    const auto put = [&](int row, int column, const fem_reference::Block<double> &block) {
        const Eigen::Matrix3d values = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Map(block.data());
        full.block<3, 3>(3 * column, 3 * row) = values.transpose();
        full.block<3, 3>(3 * row, 3 * column) = values;
    };
    for (int node = 0; 3 * node < matrix.num_rows(); ++node) {
        put(node, node, matrix.diagonal[node]);
        for (int k = matrix.rows.row_start[node]; k < matrix.rows.row_start[node + 1]; ++k)
            put(node, matrix.rows.column[k], matrix.below[k]);
    }
    return full;
}

template <class T> std::vector<T> some_vector(int size) {
    std::vector<T> vector(size);
    for (int i = 0; i < size; ++i)
        vector[i] = static_cast<T>((7 * i + 3) % 23 - 11);
    return vector;
}

/// One of some columns that stand side by side.
template <class T> Eigen::VectorXd column(const std::vector<T> &together, int number, int lanes) {
    Eigen::VectorXd result(static_cast<Eigen::Index>(together.size()) / lanes);
    for (Eigen::Index i = 0; i < result.size(); ++i)
        result[i] = static_cast<double>(together[lanes * i + number]);
    return result;
}

TEST(FemBlocks, OrderKeepsNeighboursTogether) {
    const auto system = box_system();
    const auto order = fem_reference::order_by_distance(system.cell_nodes, system.nodes_per_cell, system.num_nodes());
    ASSERT_EQ(std::set(order.begin(), order.end()).size(), system.points.size());
    const auto matrix = zero_of_blocks(system.stiffness.rows);
    std::set<int> before{order.front()};
    for (std::size_t at = 1; at < order.size(); ++at) {
        const int row = order[at];
        const auto has_come = [&](int column) { return before.contains(column); };
        EXPECT_TRUE(std::any_of(matrix.column.begin() + matrix.row_start[row],
                                matrix.column.begin() + matrix.row_start[row + 1], has_come))
            << at;
        before.insert(order[at]);
    }
}

TEST(FemBlocks, OrderTakesPartsThatDoNotTouch) {
    EXPECT_EQ(fem_reference::order_by_distance(std::array{0, 1, 2, 3}, 2, 4), (std::vector{1, 0, 3, 2}));
}

/// Numbered otherwise it is the same system.
TEST(FemBlocks, SystemsByDistanceAreThoseOfTheMesh) {
    for (const int degree : {1, 2}) {
        const auto body = box_body();
        const auto of_mesh = fem_reference::assemble(body, degree);
        const auto by_distance = fem_reference::assemble(body, degree, fem_reference::NodeOrder::by_distance);
        ASSERT_EQ(by_distance.num_nodes(), of_mesh.num_nodes());
        std::vector<int> place(of_mesh.points.size(), -1);
        for (std::size_t k = 0; k < of_mesh.cell_nodes.size(); ++k)
            place[of_mesh.cell_nodes[k]] = by_distance.cell_nodes[k];
        EXPECT_NE(place, of_mesh.mesh_node);
        for (std::size_t node = 0; node < body.mesh.points.size(); ++node) {
            EXPECT_EQ(by_distance.mesh_node[node], place[node]);
            EXPECT_EQ(by_distance.points[place[node]], body.mesh.points[node]);
        }
        for (std::size_t k = 0; k < of_mesh.facet_nodes.size(); ++k)
            EXPECT_EQ(by_distance.facet_nodes[k], place[of_mesh.facet_nodes[k]]);
        Eigen::VectorXi dof(3 * of_mesh.num_nodes());
        for (int row = 0; row < dof.size(); ++row)
            dof[row] = 3 * place[row / 3] + row % 3;
        const Eigen::MatrixXd expected = dense(of_mesh.stiffness);
        EXPECT_LT((dense(by_distance.stiffness)(dof, dof) - expected).norm(), 1e-14 * expected.norm());
    }
}

template <class T> class FemBlocksProducts : public testing::Test {};
using Numbers = testing::Types<float, double>;
TYPED_TEST_SUITE(FemBlocksProducts, Numbers);

TYPED_TEST(FemBlocksProducts, AreThoseOfTheWholeMatrix) {
    using T = TypeParam;
    const double tolerance = 50.0 * static_cast<double>(std::numeric_limits<T>::epsilon());
    const auto matrix = box_system().stiffness;
    const Eigen::MatrixXd full = dense(matrix);
    for (const int lanes : {1, 4, 8}) {
        const auto x = some_vector<T>(lanes * matrix.num_rows());
        std::vector<T> blocks(x.size()), rows(x.size());
        if constexpr (std::is_same_v<T, float>)
            rounded(matrix).multiply(x, blocks);
        else
            matrix.multiply(x, blocks);
        fem_reference::multiply(compressed_rows(matrix), std::span<const T>(x), std::span<T>(rows), lanes);
        for (int c = 0; c < lanes; ++c) {
            const Eigen::VectorXd expected = full * column(x, c, lanes);
            EXPECT_LT((column(blocks, c, lanes) - expected).norm(), tolerance * expected.norm())
                << c << " of " << lanes;
            EXPECT_LT((column(rows, c, lanes) - expected).norm(), tolerance * expected.norm()) << c << " of " << lanes;
        }
    }
}

TEST(FemBlocks, CompressedRowsAreTheWholeMatrix) {
    const auto blocks = box_system().stiffness;
    const auto matrix = compressed_rows(blocks);
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(matrix.num_rows(), matrix.num_rows());
    for (int row = 0; row < matrix.num_rows(); ++row) {
        EXPECT_TRUE(std::is_sorted(matrix.column.begin() + matrix.row_start[row],
                                   matrix.column.begin() + matrix.row_start[row + 1], std::less_equal<>()));
        for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k)
            full(row, matrix.column[k]) = matrix.value[k];
    }
    EXPECT_EQ(full, dense(blocks));
    EXPECT_EQ(matrix.value.size(), 9 * (2 * blocks.below.size() + blocks.diagonal.size()));
}

/// Sweeps are triangular solves; columns constrain a whole node, single components of others, or nothing.
TEST(FemBlocks, SweepsAreTriangularSolves) {
    const auto matrix = box_system().stiffness;
    const int size = matrix.num_rows();
    std::vector<std::vector<double>> prescribed(2, std::vector<double>(size, std::numeric_limits<double>::quiet_NaN()));
    for (int dof = 0; dof < size; ++dof)
        if (dof % 7 == 2 || dof / 3 == 5)
            prescribed[0][dof] = 0.0;
    for (const std::size_t num_columns : {1, 3, 7}) {
        std::vector<std::span<const double>> of_columns;
        for (std::size_t c = 0; c < num_columns; ++c)
            of_columns.emplace_back(prescribed[c % 2]);
        const auto free = fem_reference::free_unknowns(of_columns);
        const int lanes = free.lanes();
        auto right_hand_side = some_vector<float>(lanes * size), start = some_vector<float>(lanes * size + 5);
        start.resize(right_hand_side.size());
        for (const auto entry : fem_reference::constrained_entries(free))
            right_hand_side[entry] = start[entry] = 0.0F;
        const auto rounded_matrix = rounded(matrix);
        fem_reference::BlockGaussSeidel smoother(rounded_matrix);
        smoother.set_up(free);
        std::vector<float> forward(start.size(), 7.0F), residual(start.size(), 7.0F);
        smoother.sweep_forward_from_zero(right_hand_side, forward, residual);
        auto backward = start;
        smoother.sweep_backward(right_hand_side, backward);

        for (std::size_t c = 0; c < num_columns; ++c) {
            SCOPED_TRACE(c);
            Eigen::MatrixXd k = dense(matrix);
            for (int dof = 0; dof < size; ++dof)
                if (prescribed[c % 2][dof] == 0.0) {
                    k.row(dof).setZero();
                    k.col(dof).setZero();
                    k(dof, dof) = 1.0;
                }
            Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(size, size); // with the blocks of the diagonal
            for (int row = 0; row < size; ++row)
                lower.row(row).head(3 * (row / 3) + 3) = k.row(row).head(3 * (row / 3) + 3);
            const auto near = [&](const std::vector<float> &found, const Eigen::VectorXd &expected) {
                constexpr double single_precision = 1e-5;
                EXPECT_LT((column(found, c, lanes) - expected).norm(), single_precision * expected.norm());
            };
            const Eigen::VectorXd b = column(right_hand_side, c, lanes), u = column(start, c, lanes);
            const Eigen::VectorXd swept = lower.partialPivLu().solve(b);
            near(forward, swept);
            near(residual, b - k * swept);
            near(backward, u + lower.transpose().partialPivLu().solve(b - k * u));
        }
    }
}

TEST(FemColumns, StandSideBySide) {
    using fem_reference::lanes_for;
    EXPECT_EQ((std::vector{lanes_for(1), lanes_for(2), lanes_for(4), lanes_for(5), lanes_for(8)}),
              (std::vector{1, 4, 4, 8, 8}));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<double> first{nan, 0.0, nan}, second{0.0, nan, nan};
    const auto free = fem_reference::free_unknowns(std::vector<std::span<const double>>{first, second, first});
    EXPECT_EQ(free.set, (std::vector{0, 1, 0, 0}));
    EXPECT_EQ(free.sets, (std::vector<std::vector<bool>>{{true, false, true}, {false, true, true}}));
    EXPECT_EQ(fem_reference::constrained_entries(free), (std::vector<std::size_t>{1, 4, 6, 7}));
    std::vector<double> y{1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0};
    EXPECT_EQ(fem_reference::separated(y, 4, 2), (std::vector<std::vector<double>>{{1.0, 5.0}, {2.0, 6.0}}));
    EXPECT_EQ(fem_reference::dots(y, y, 4), (std::vector{26.0, 40.0, 58.0, 80.0}));
    fem_reference::scale(std::array{1.0, 0.0, 2.0, 1.0}, y);
    EXPECT_EQ(y, (std::vector{1.0, 0.0, 6.0, 4.0, 5.0, 0.0, 14.0, 8.0}));
}

template <class T> void expect_products_of(const fem_reference::DivergenceRows<T> &rows, const Eigen::MatrixXd &full) {
    for (const int lanes : {1, 4, 8}) {
        SCOPED_TRACE(lanes);
        const auto some = [lanes](Eigen::Index size, int seed) {
            std::vector<T> values(lanes * size);
            for (std::size_t i = 0; i < values.size(); ++i)
                values[i] = static_cast<T>((7 * static_cast<int>(i) + seed) % 23 - 11);
            return values;
        };
        const auto of_columns = [lanes](const std::vector<T> &values) -> Eigen::MatrixXd {
            using Together = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
            return Together::Map(values.data(), static_cast<Eigen::Index>(values.size()) / lanes, lanes)
                .template cast<double>();
        };
        const auto near = [&](const std::vector<T> &found, const Eigen::MatrixXd &expected) {
            EXPECT_LT((of_columns(found) - expected).norm(),
                      30.0 * static_cast<double>(std::numeric_limits<T>::epsilon()) * expected.norm());
        };
        const auto u = some(full.cols(), 3), g = some(full.rows(), 5), force = some(full.cols(), 8);
        std::vector<T> less(g.size()), summed = force, imbalance = g;
        rows.subtract_product(u, g, less, lanes);
        near(less, full * of_columns(u) - of_columns(g));
        rows.add_products(u, g, summed, imbalance, lanes);
        near(summed, of_columns(force) + full.transpose() * of_columns(g));
        near(imbalance, full * of_columns(u) - of_columns(g));
    }
}

TEST(FemDivergence, ProductsAreThoseOfTheMatrix) {
    core::Body body;
    body.mesh = tests::shaken_box_mesh({0.1, 0.08, 0.06}, {3, 2, 2});
    body.mesh.region_names = {"left", "right"};
    for (std::size_t t = 0; t < body.mesh.region.size() / 2; ++t)
        body.mesh.region[t] = 1;
    body.materials = {{1060.0, 5000.0, 0.45}, {1060.0, 50000.0, 0.499}};
    const auto system = fem_reference::assemble(fem_reference::without_pressure(body), 2);
    auto rows = fem_reference::assemble_pressure(body, system).divergence;
    for (auto &of_node : rows.value) // of the size of what they are multiplied with
        for (double &value : of_node)
            value *= 1e4;
    const auto full = tests::dense(rows, 3 * system.num_nodes());
    ASSERT_GT(full.norm(), 0.0);
    expect_products_of(rows, full);
    expect_products_of(rounded(rows), full);
}

using fem_reference::CellEntries;

/// Corners of tetrahedra, one behind the other.
std::vector<int> corners_of(const core::TetraMesh &mesh) {
    std::vector<int> corners;
    for (const auto &nodes : mesh.tetrahedra)
        corners.insert(corners.end(), nodes.begin(), nodes.end());
    return corners;
}

/// The pairs of a row and a column that have an entry.
std::set<std::pair<int, int>> entries(const fem_reference::CellRows &rows) {
    std::set<std::pair<int, int>> all;
    for (std::size_t row = 0; row + 1 < rows.row_start.size(); ++row)
        for (int k = rows.row_start[row]; k < rows.row_start[row + 1]; ++k)
            all.emplace(static_cast<int>(row), rows.column[k]);
    return all;
}

class CellRowsOfABox : public testing::Test {
  protected:
    core::TetraMesh mesh = tests::shaken_box_mesh({0.1, 0.08, 0.06}, {3, 2, 2});
    std::vector<int> nodes = corners_of(mesh);

    fem_reference::CellRows rows(CellEntries wanted) const {
        return fem_reference::cell_rows(nodes, 4, mesh.num_nodes(), nodes, 4, mesh.num_nodes(), wanted);
    }
};

TEST_F(CellRowsOfABox, HaveThePairsOfAllCellsOnceInOrder) {
    std::set<std::pair<int, int>> all, below;
    for (std::size_t k = 0; k < nodes.size(); ++k)
        for (std::size_t other = k - k % 4; other < k - k % 4 + 4; ++other) {
            all.emplace(nodes[k], nodes[other]);
            if (nodes[other] < nodes[k])
                below.emplace(nodes[k], nodes[other]);
        }
    for (const auto &[wanted, expected] : {std::pair(CellEntries::all, all), {CellEntries::below_diagonal, below}}) {
        const auto found = rows(wanted);
        EXPECT_EQ(found.column.size(), expected.size());
        EXPECT_EQ(entries(found), expected);
        for (int row = 0; row < mesh.num_nodes(); ++row)
            EXPECT_TRUE(std::is_sorted(found.column.begin() + found.row_start[row],
                                       found.column.begin() + found.row_start[row + 1]));
    }
}

TEST_F(CellRowsOfABox, KnowWhereEachPairOfACellStands) {
    for (const auto wanted : {CellEntries::all, CellEntries::below_diagonal}) {
        const auto found = rows(wanted);
        ASSERT_EQ(found.place.size(), 4 * nodes.size());
        for (std::size_t pair = 0; pair < found.place.size(); ++pair) {
            const int row = nodes[pair / 4], column = nodes[4 * (pair / 16) + pair % 4], at = found.place[pair];
            if (wanted == CellEntries::below_diagonal && column >= row) {
                EXPECT_EQ(at, -1);
                continue;
            }
            ASSERT_GE(at, found.row_start[row]);
            ASSERT_LT(at, found.row_start[row + 1]);
            EXPECT_EQ(found.column[at], column);
        }
    }
}

TEST(CellRows, LeaveOutCellsThatHaveNoRow) {
    const std::vector rows{-1, -1, 1, 0}, columns{7, 8, 9, 4, 5, 2};
    const auto found = fem_reference::cell_rows(rows, 2, 2, columns, 3, 10);
    EXPECT_EQ(found.row_start, (std::vector{0, 3, 6}));
    EXPECT_EQ(found.column, (std::vector{2, 4, 5, 2, 4, 5}));
    EXPECT_EQ(found.place, (std::vector{-1, -1, -1, -1, -1, -1, 4, 5, 3, 1, 2, 0}));
}

} // namespace
} // namespace livermark
