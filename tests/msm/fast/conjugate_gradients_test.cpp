#include <Eigen/Cholesky>
#include <cmath>
#include <gtest/gtest.h>

#include "msm/statics/rest_stiffness.hpp"

namespace livermark {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int size = 12;

MatrixXd positive_definite() {
    MatrixXd matrix = MatrixXd::Identity(size, size);
    for (int i = 0; i < size; ++i)
        for (int j = 0; j < size; ++j)
            matrix(i, j) += std::cos(i + 1.0) * std::cos(j + 1.0) + (i == j ? i : 0.1);
    return matrix;
}

VectorXd identity(const VectorXd &b) {
    return b;
}

TEST(ConjugateGradients, FindTheSolutionInAsManyStepsAsThereAreUnknowns) {
    const MatrixXd matrix = positive_definite();
    const VectorXd b = VectorXd::LinSpaced(size, -1.0, 2.0);
    const VectorXd x =
        msm::conjugate_gradients([&](const VectorXd &v) -> VectorXd { return matrix * v; }, identity, b, 1e-12, size);
    EXPECT_LT((matrix * x - b).norm(), 1e-10 * b.norm());
}

TEST(ConjugateGradients, NeedOneStepWithTheInverse) {
    const MatrixXd matrix = positive_definite();
    const Eigen::LLT<MatrixXd> factor(matrix);
    const VectorXd b = VectorXd::LinSpaced(size, -1.0, 2.0);
    int num_products = 0;
    const auto times = [&](const VectorXd &v) -> VectorXd {
        ++num_products;
        return matrix * v;
    };
    const VectorXd x = msm::conjugate_gradients(
        times, [&](const VectorXd &v) -> VectorXd { return factor.solve(v); }, b, 1e-12, size);
    EXPECT_EQ(num_products, 1);
    EXPECT_LT((matrix * x - b).norm(), 1e-12 * b.norm());
}

TEST(ConjugateGradients, GoDownhillWhereTheMatrixIsIndefinite) {
    MatrixXd matrix = positive_definite();
    const VectorXd b = VectorXd::LinSpaced(size, -1.0, 2.0);
    for (const double shift : {2.0, 5.0, 100.0}) {
        const MatrixXd indefinite = matrix - shift * MatrixXd::Identity(size, size);
        ASSERT_EQ(Eigen::LLT<MatrixXd>(indefinite).info(), Eigen::NumericalIssue);
        const VectorXd x = msm::conjugate_gradients([&](const VectorXd &v) -> VectorXd { return indefinite * v; },
                                                    identity, b, 1e-12, size);
        EXPECT_GT(b.dot(x), 0.0) << shift;
        EXPECT_TRUE(x.allFinite());
    }
}

} // namespace
} // namespace livermark
