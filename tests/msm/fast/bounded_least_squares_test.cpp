#include <Eigen/Cholesky>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <stdexcept>

#include "msm/bounded_least_squares.hpp"

namespace livermark {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

msm::BoundedLeastSquares solve(const MatrixXd &matrix, const VectorXd &target, const VectorXd &lower) {
    return msm::solve_bounded_least_squares(matrix.sparseView(), target, lower);
}

/// The best of all 2^n choices of unknowns at their bound that keeps the others above theirs.
VectorXd brute_force(const MatrixXd &matrix, const VectorXd &target, const VectorXd &lower) {
    const auto n = static_cast<int>(matrix.cols());
    VectorXd best;
    double least = std::numeric_limits<double>::infinity();
    for (unsigned choice = 0; choice < (1U << n); ++choice) {
        std::vector<int> free;
        for (int i = 0; i < n; ++i)
            if ((choice >> i & 1U) != 0)
                free.push_back(i);
        VectorXd x = lower;
        if (!free.empty()) {
            const MatrixXd part = matrix(Eigen::all, free);
            x(free) += (part.transpose() * part).ldlt().solve(part.transpose() * (target - matrix * lower));
        }
        const double size = (matrix * x - target).squaredNorm();
        if ((x - lower).minCoeff() >= 0.0 && size < least) {
            least = size;
            best = x;
        }
    }
    return best;
}

struct RandomProblem {
    MatrixXd matrix;
    VectorXd target;
    VectorXd lower;
};

/// @param likeness  of the columns to each other, 0 ... 1; the more alike, the more unknowns end at their bound
RandomProblem random_problem(std::mt19937 &random, int rows, int columns, double likeness) {
    std::normal_distribution<double> normal;
    const auto draw = [&] { return normal(random); };
    const VectorXd common = VectorXd::NullaryExpr(rows, draw);
    RandomProblem problem{MatrixXd::NullaryExpr(rows, columns, draw), VectorXd::NullaryExpr(rows, draw),
                          VectorXd::NullaryExpr(columns, draw)};
    problem.matrix = (1.0 - likeness) * problem.matrix + likeness * common.rowwise().replicate(columns);
    return problem;
}

TEST(BoundedLeastSquares, IsOrdinaryLeastSquaresWhereNoBoundIsMet) {
    const MatrixXd matrix{{1.0, 1.0}, {1.0, 2.0}, {1.0, 3.0}}; // the line through (1, 6), (2, 0), (3, 0)
    const auto result = solve(matrix, VectorXd{{6.0, 0.0, 0.0}}, VectorXd::Constant(2, -100.0));
    EXPECT_NEAR(result.x[0], 8.0, 1e-12);
    EXPECT_NEAR(result.x[1], -3.0, 1e-12);
    EXPECT_EQ(result.num_solves, 1);
}

TEST(BoundedLeastSquares, StopsAtTheBoundItself) {
    const MatrixXd matrix{{1.0, 1.0}, {1.0, 2.0}, {1.0, 3.0}}; // the same with a slope of 0.1 or more: 2 - 0.2
    const auto result = solve(matrix, VectorXd{{6.0, 0.0, 0.0}}, VectorXd{{-100.0, 0.1}});
    EXPECT_NEAR(result.x[0], 1.8, 1e-12);
    EXPECT_EQ(result.x[1], 0.1);
}

TEST(BoundedLeastSquares, GivesTheBoundsWhereEverythingIsPushedDown) {
    const VectorXd lower{{0.5, 0.25, 1.0}};
    EXPECT_EQ(solve(MatrixXd::Identity(3, 3), VectorXd::Constant(3, -1.0), lower).x, lower);
}

TEST(BoundedLeastSquares, TakesTheBestOfAllChoicesOfBounds) {
    std::mt19937 random(7);
    for (int repeat = 0; repeat < 200; ++repeat) {
        const auto [matrix, target, lower] = random_problem(random, 10, 7, 0.1 * (repeat % 10));
        const VectorXd expected = brute_force(matrix, target, lower);
        const auto result = solve(matrix, target, lower);
        EXPECT_LT((result.x - expected).norm(), 1e-8 * (1.0 + expected.norm())) << "problem " << repeat;
    }
}

/// Feasible, no gradient towards the inside at a bound, none at all where free.
TEST(BoundedLeastSquares, MeetsTheConditionsOfKarushKuhnAndTucker) {
    std::mt19937 random(11);
    for (const double likeness : {0.0, 0.1, 0.2}) {
        const auto [matrix, target, lower] = random_problem(random, 400, 300, likeness);
        const auto result = solve(matrix, target, lower);
        const VectorXd lengths = matrix.colwise().norm();
        const VectorXd gradient = (matrix.transpose() * (matrix * result.x - target)).cwiseQuotient(lengths);
        const double tolerance = 1e-10 * (target - matrix * lower).norm();
        int at_bound = 0;
        for (Eigen::Index i = 0; i < lower.size(); ++i) {
            EXPECT_GE(result.x[i], lower[i]);
            EXPECT_GE(gradient[i], -tolerance);
            if (result.x[i] > lower[i])
                EXPECT_LE(gradient[i], tolerance);
            else
                ++at_bound;
        }
        EXPECT_GT(at_bound, 30);
        EXPECT_LT(at_bound, 270);
    }
}

TEST(BoundedLeastSquares, GivesTheSameSolutionTwice) {
    std::mt19937 random(13);
    const auto [matrix, target, lower] = random_problem(random, 200, 150, 0.5);
    EXPECT_EQ(solve(matrix, target, lower).x, solve(matrix, target, lower).x);
}

TEST(BoundedLeastSquares, GivesOneOfTheMinimisersWhereColumnsDependOnEachOther) {
    const MatrixXd matrix{{1.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    const VectorXd target{{3.0, -1.0}};
    const VectorXd x = solve(matrix, target, VectorXd::Zero(3)).x;
    EXPECT_NEAR((matrix * x - target).norm(), 1.0, 1e-12);
    EXPECT_GE(x.minCoeff(), 0.0);
}

TEST(BoundedLeastSquares, RefusesColumnsOfZerosAndShapesThatDiffer) {
    const VectorXd two = VectorXd::Ones(2);
    EXPECT_THROW(solve(MatrixXd{{1.0, 0.0}, {1.0, 0.0}}, two, two), std::invalid_argument);
    EXPECT_THROW(solve(MatrixXd::Identity(2, 2), VectorXd::Ones(3), two), std::invalid_argument);
    EXPECT_THROW(solve(MatrixXd::Identity(2, 2), two, VectorXd::Ones(3)), std::invalid_argument);
}

} // namespace
} // namespace livermark
