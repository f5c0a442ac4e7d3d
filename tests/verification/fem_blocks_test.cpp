#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <set>

#include "fem_reference/block_gauss_seidel.hpp"
#include "fem_reference/node_order.hpp"
#include "fem_reference/symmetric_blocks.hpp"
#include "tests/verification/fem_test_bodies.hpp"

namespace livermark {
namespace {

/// Quadratic elements on a shaken box: rows of all lengths.
fem_reference::ElasticSystem box_system() {
    core::Body body;
    body.mesh = tests::shaken_box_mesh({0.1, 0.08, 0.06}, {3, 2, 2});
    body.materials = {{1060.0, 5000.0, 0.4}};
    return fem_reference::assemble(body, 2);
}

Eigen::MatrixXd dense(const fem_reference::SymmetricMatrix &matrix) {
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(matrix.num_rows(), matrix.num_rows());
    for (int row = 0; row < matrix.num_rows(); ++row)
        for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k)
            full(row, matrix.column[k]) = matrix.value[k];
    return full;
}

std::vector<double> some_vector(int size) {
    std::vector<double> vector(size);
    for (int i = 0; i < size; ++i)
        vector[i] = static_cast<double>((7 * i + 3) % 23 - 11);
    return vector;
}

double relative_difference(const std::vector<double> &found, const Eigen::VectorXd &expected) {
    return (Eigen::VectorXd::Map(found.data(), expected.size()) - expected).norm() / expected.norm();
}

TEST(FemBlocks, OrderKeepsNeighboursTogether) {
    const auto matrix = box_system().stiffness;
    const auto order = fem_reference::order_by_distance(matrix);
    ASSERT_EQ(std::set(order.begin(), order.end()).size(), static_cast<std::size_t>(matrix.num_rows() / 3));
    std::set<int> before{order.front()};
    for (std::size_t at = 1; at < order.size(); ++at) {
        const int row = 3 * order[at];
        const auto has_come = [&](int column) { return before.contains(column / 3); };
        EXPECT_TRUE(std::any_of(matrix.column.begin() + matrix.row_start[row],
                                matrix.column.begin() + matrix.row_start[row + 1], has_come))
            << at;
        before.insert(order[at]);
    }
}

TEST(FemBlocks, OrderTakesPartsThatDoNotTouch) {
    fem_reference::SymmetricMatrix two;
    two.row_start.push_back(0);
    for (int row = 0; row < 6; ++row) {
        for (int i = 0; i < 3; ++i)
            two.column.push_back(row / 3 * 3 + i);
        two.row_start.push_back(static_cast<int>(two.column.size()));
    }
    two.value.assign(two.column.size(), 1.0);
    EXPECT_EQ(fem_reference::order_by_distance(two), (std::vector{0, 1}));
}

TEST(FemBlocks, ProductIsThatOfTheWholeMatrix) {
    const auto matrix = box_system().stiffness;
    const auto x = some_vector(matrix.num_rows());
    std::vector<double> found(x.size());
    fem_reference::SymmetricBlocks(matrix).multiply(x, found);
    EXPECT_LT(relative_difference(found, dense(matrix) * Eigen::VectorXd::Map(x.data(), matrix.num_rows())), 1e-14);
}

/// Sweeps are triangular solves in the order of the nodes.
TEST(FemBlocks, SweepsAreTriangularSolves) {
    const auto matrix = box_system().stiffness;
    const int size = matrix.num_rows();
    const auto order = fem_reference::order_by_distance(matrix);
    std::vector<bool> is_free(size, true);
    for (int dof = 0; dof < size; ++dof)
        is_free[dof] = dof % 7 != 2 && dof / 3 != 5; // a whole node, and single components of others
    auto right_hand_side = some_vector(size);
    Eigen::MatrixXd constrained = dense(matrix);
    for (int dof = 0; dof < size; ++dof)
        if (!is_free[dof]) {
            right_hand_side[dof] = 0.0;
            constrained.row(dof).setZero();
            constrained.col(dof).setZero();
            constrained(dof, dof) = 1.0;
        }
    Eigen::VectorXi place(size);
    for (int at = 0; at < size; ++at)
        place[at] = 3 * order[at / 3] + at % 3;
    const Eigen::MatrixXd k = constrained(place, place);
    const Eigen::VectorXd b = Eigen::VectorXd::Map(right_hand_side.data(), size)(place);
    Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(size, size); // with the blocks of the diagonal
    for (int row = 0; row < size; ++row)
        lower.row(row).head(3 * (row / 3) + 3) = k.row(row).head(3 * (row / 3) + 3);
    const auto in_place = [&](const Eigen::VectorXd &ordered) {
        Eigen::VectorXd result(size);
        result(place) = ordered;
        return result;
    };

    fem_reference::BlockGaussSeidel smoother(matrix, is_free);
    std::vector<double> u(size, 7.0), residual(size, 7.0);
    smoother.sweep_forward_from_zero(right_hand_side, u, residual);
    const Eigen::VectorXd forward = lower.partialPivLu().solve(b);
    constexpr double single_precision = 1e-5;
    EXPECT_LT(relative_difference(u, in_place(forward)), single_precision);
    EXPECT_LT(relative_difference(residual, in_place(b - k * forward)), single_precision);

    u = some_vector(size);
    for (int dof = 0; dof < size; ++dof)
        u[dof] = is_free[dof] ? u[dof] : 0.0;
    const Eigen::VectorXd start = Eigen::VectorXd::Map(u.data(), size)(place);
    const Eigen::VectorXd backward = start + lower.transpose().partialPivLu().solve(b - k * start);
    smoother.sweep_backward(right_hand_side, u);
    EXPECT_LT(relative_difference(u, in_place(backward)), single_precision);
}

} // namespace
} // namespace livermark
