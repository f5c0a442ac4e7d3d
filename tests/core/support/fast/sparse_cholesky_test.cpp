#include <Eigen/Dense>
#include <algorithm>
#include <gtest/gtest.h>
#include <numeric>
#include <random>
#include <thread>
#include <vector>

#include "core/support/factors/sparse_cholesky.hpp"

namespace livermark {
namespace {

using Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;

/// Neighbours on a grid of side^3 pull at each other by random springs, and all are constrained a little.
Sparse grid_of_springs(int side, double constrained = 0.1) {
    std::mt19937 generator(7);
    std::uniform_real_distribution<double> stiffness(0.5, 2.0);
    const int size = side * side * side;
    std::vector<Eigen::Triplet<double>> entries;
    for (int at = 0; at < size; ++at) {
        entries.emplace_back(at, at, constrained);
        for (const auto &[step, place] :
             {std::pair{1, at % side}, {side, at / side % side}, {side * side, at / side / side}})
            if (place + 1 < side) {
                const double k = stiffness(generator);
                entries.emplace_back(at, at, k);
                entries.emplace_back(at + step, at + step, k);
                entries.emplace_back(at, at + step, -k);
                entries.emplace_back(at + step, at, -k);
            }
    }
    Sparse matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

MatrixXd some_vectors(Eigen::Index rows, Eigen::Index columns) {
    std::mt19937 generator(3);
    std::normal_distribution<double> number;
    return MatrixXd::NullaryExpr(rows, columns, [&] { return number(generator); });
}

/// Solution with the matrix without the rows and columns of what is constrained.
MatrixXd dense_solution(const Sparse &matrix, const std::vector<int> &constrained, MatrixXd right_hand_sides) {
    MatrixXd dense = matrix;
    for (const int unknown : constrained) {
        dense.row(unknown).setZero();
        dense.col(unknown).setZero();
        dense(unknown, unknown) = 1.0;
        right_hand_sides.row(unknown).setZero();
    }
    return dense.ldlt().solve(right_hand_sides);
}

class SparseCholesky : public testing::Test {
  protected:
    SparseCholesky() {
        factor.order(matrix);
        EXPECT_TRUE(factor.factorise(matrix));
    }
    void expect_solutions_with(const std::vector<int> &constrained) {
        const auto found = factor.solve(right_hand_sides);
        const auto expected = dense_solution(matrix, constrained, right_hand_sides);
        EXPECT_LT((found - expected).norm(), 1e-12 * right_hand_sides.norm());
        for (const int unknown : constrained)
            EXPECT_EQ(found.row(unknown).norm(), 0.0);
    }

    Sparse matrix = grid_of_springs(8);
    MatrixXd right_hand_sides = some_vectors(matrix.rows(), 3);
    support::SparseCholesky factor;
};

TEST_F(SparseCholesky, SolvesForSeveralVectors) {
    expect_solutions_with({});
    EXPECT_GT(factor.pivot_ratio(), 1e-3);
}

TEST(SparseCholeskyInThreads, FindsTheBitsThatItFindsAlone) {
    const auto matrix = grid_of_springs(20);
    const auto right_hand_sides = some_vectors(matrix.rows(), 1);
    const auto solution = [&] {
        support::SparseCholesky factor;
        factor.order(matrix);
        return factor.factorise(matrix) ? factor.solve(right_hand_sides) : MatrixXd();
    };
    const MatrixXd alone = solution();
    ASSERT_EQ(alone.rows(), matrix.rows());
    std::vector<MatrixXd> found(12);
    {
        std::vector<std::jthread> threads;
        for (int thread = 0; thread < 4; ++thread)
            threads.emplace_back([&, thread] {
                for (std::size_t i = thread; i < found.size(); i += 4)
                    found[i] = solution();
            });
    }
    for (const auto &other : found)
        EXPECT_EQ(other, alone);
}

TEST_F(SparseCholesky, KeepsConstrainedUnknownsAtZero) {
    for (const std::vector<int> &constrained : {std::vector{5}, std::vector{300, 2, 77, 511}}) {
        factor.constrain(constrained);
        expect_solutions_with(constrained);
    }
    std::vector<int> many(150); // more than are solved for at once
    std::iota(many.begin(), many.end(), 100);
    factor.constrain(many);
    expect_solutions_with(many);
}

TEST_F(SparseCholesky, SolvesRoughlyToSinglePrecision) {
    right_hand_sides.col(1) *= 1e60; // beyond single precision
    right_hand_sides.col(2).setZero();
    for (const std::vector<int> &constrained : {std::vector<int>{}, {300, 2, 77, 511}}) {
        factor.constrain(constrained);
        for (const Eigen::Index num_columns : {1, 3}) { // vectors and matrices go different ways
            const MatrixXd some = right_hand_sides.leftCols(num_columns);
            const MatrixXd expected = factor.solve(some), found = factor.solve_single_precision(some);
            for (Eigen::Index c = 0; c < num_columns; ++c)
                EXPECT_LE((found.col(c) - expected.col(c)).norm(), 1e-5 * expected.col(c).norm()) << c;
            for (const int unknown : constrained)
                EXPECT_EQ(found.row(unknown).norm(), 0.0);
        }
    }
}

TEST_F(SparseCholesky, SolvesRoughlyWithTheLastFactor) {
    factor.solve_single_precision(right_hand_sides);
    matrix *= 2.0;
    EXPECT_TRUE(factor.factorise(matrix));
    const MatrixXd expected = factor.solve(right_hand_sides);
    EXPECT_LT((factor.solve_single_precision(right_hand_sides) - expected).norm(), 1e-5 * expected.norm());
}

TEST_F(SparseCholesky, ClearsWhatWasConstrained) {
    const MatrixXd before = factor.solve(right_hand_sides);
    factor.constrain({1, 2, 3});
    factor.constrain({});
    EXPECT_EQ(factor.solve(right_hand_sides), before);
    factor.constrain({1, 2, 3});
    EXPECT_TRUE(factor.factorise(matrix));
    EXPECT_EQ(factor.solve(right_hand_sides), before);
}

TEST_F(SparseCholesky, DoesNotLookAtTheLoadOfConstrainedUnknowns) {
    factor.constrain({10, 20});
    const MatrixXd before = factor.solve(right_hand_sides);
    right_hand_sides.row(10).setConstant(50.0);
    EXPECT_LT((factor.solve(right_hand_sides) - before).norm(), 1e-12 * before.norm());
}

TEST_F(SparseCholesky, TakesOtherValuesInTheSamePlaces) {
    matrix *= 2.0;
    matrix.diagonal().array() += 1.0;
    EXPECT_TRUE(factor.factorise(matrix));
    expect_solutions_with({});
}

TEST_F(SparseCholesky, SaysWhenAMatrixIsNotPositiveDefinite) {
    matrix.diagonal().array() -= 5.0;
    EXPECT_FALSE(factor.factorise(matrix));
}

TEST(UnknownsToHold, AreThoseOfTheFactorThatAreNotFree) {
    std::vector<bool> has(1000, true), free(1000, true);
    has[0] = free[0] = false;
    free[1] = free[500] = false;
    EXPECT_EQ(support::unknowns_to_constrain(has, free), (std::vector{0, 499}));
    EXPECT_EQ(support::unknowns_to_constrain(has, has), std::vector<int>{});
}

TEST(UnknownsToHold, NeedAFactorOfAllThatIsFree) {
    const std::vector<bool> has{true, false, true}, free{true, true, true};
    EXPECT_FALSE(support::unknowns_to_constrain(has, free));
}

TEST(UnknownsToHold, AreFewOfMany) {
    std::vector<bool> has(8000, true), free = has;
    std::fill_n(free.begin(), 79, false); // a fifth of the square of the cube root is 80
    EXPECT_TRUE(support::unknowns_to_constrain(has, free));
    free[79] = free[80] = false;
    EXPECT_FALSE(support::unknowns_to_constrain(has, free));
}

TEST(SparseCholeskyInAGivenOrder, SolvesAndFillsInAsMuchAsTheOrderDoes) {
    const auto matrix = grid_of_springs(6);
    std::vector<int> order(static_cast<std::size_t>(matrix.rows()));
    std::iota(order.begin(), order.end(), 0);
    std::ranges::shuffle(order, std::mt19937(5));
    const auto right_hand_sides = some_vectors(matrix.rows(), 2);
    support::SparseCholesky factor, again;
    factor.order(matrix, order);
    ASSERT_TRUE(factor.factorise(matrix));
    const MatrixXd expected = dense_solution(matrix, {}, right_hand_sides);
    EXPECT_LT((factor.solve(right_hand_sides) - expected).norm(), 1e-12 * expected.norm());
    again.order(matrix, factor.factor().order);
    ASSERT_TRUE(again.factorise(matrix));
    EXPECT_EQ(again.factor().values.size(), factor.factor().values.size());
    // Its own order has less to fill in.
    support::SparseCholesky own;
    own.order(matrix);
    ASSERT_TRUE(own.factorise(matrix));
    EXPECT_LT(own.factor().values.size(), factor.factor().values.size());
}

} // namespace
} // namespace livermark
