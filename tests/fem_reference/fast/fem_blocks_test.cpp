#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <set>
#include <type_traits>

#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/node_order.hpp"
#include "fem_reference/solvers/multigrid/block_gauss_seidel.hpp"
#include "fem_reference/solvers/multivector.hpp"
#include "fem_reference/solvers/symmetric_blocks.hpp"
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

} // namespace
} // namespace livermark
