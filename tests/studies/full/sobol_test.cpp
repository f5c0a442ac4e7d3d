#include "studies/sensitivity/sobol.hpp"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>

#include "tests/livermark_command.hpp"

namespace livermark::studies {
namespace {

/// These tests are of our use of OpenTURNS, and skipped where it is not.
class SobolIndex : public testing::Test {
  protected:
    void SetUp() override {
        if (tests::run_command("/usr/bin/python3 -c 'import openturns'").status != 0)
            GTEST_SKIP() << "OpenTURNS is missing; apt-get install python3-openturns";
    }

    static std::vector<double> values_at(const std::vector<std::vector<double>> &points,
                                         const std::function<double(const std::vector<double> &)> &function) {
        std::vector<double> values;
        for (const auto &point : points)
            values.push_back(function(point));
        return values;
    }
};

/// sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1 on [-pi, pi]^3.
/// (T. Ishigami and T. Homma 1990, An importance quantification technique in uncertainty analysis for computer models)
double ishigami(const std::vector<double> &unit) {
    const auto x = [&](std::size_t p) { return std::numbers::pi * (2.0 * unit[p] - 1.0); };
    return std::sin(x(0)) + 7.0 * std::pow(std::sin(x(1)), 2.0) + 0.1 * std::pow(x(2), 4.0) * std::sin(x(0));
}

TEST_F(SobolIndex, OfIshigamisFunctionIsTheExactOne) {
    const auto points = sobol_points(512, 3);
    const auto found = sobol_indices(points, {values_at(points, ishigami)}, {{0, 2}, {1}}).front();
    const std::vector<double> first{0.3139, 0.4424, 0.0}, total{0.5576, 0.4424, 0.2437};
    for (std::size_t p = 0; p < 3; ++p) {
        EXPECT_NEAR(found.first[p], first[p], 2e-4);
        EXPECT_NEAR(found.total[p], total[p], 2e-4);
    }
    EXPECT_NEAR(found.group_total[0], 0.5576, 2e-4) << "of the two that act together";
    EXPECT_NEAR(found.group_total[1], 0.4424, 2e-4);
    EXPECT_LT(found.unexplained, 1e-6);
}

/// With as few samples as a study of a liver has the intervals hold the exact indices, and say how much is unknown.
TEST_F(SobolIndex, IsInItsIntervalWithFewSamples) {
    const auto points = sobol_points(256, 3);
    const auto found = sobol_indices(points, {values_at(points, ishigami)}, {{0}}).front();
    const std::vector<double> first{0.31390, 0.44241, 0.0}, total{0.55759, 0.44241, 0.24368};
    for (std::size_t p = 0; p < 3; ++p) {
        EXPECT_LE(found.first_lower[p], first[p]);
        EXPECT_GE(found.first_upper[p], first[p]);
        EXPECT_LE(found.total_lower[p], total[p]);
        EXPECT_GE(found.total_upper[p], total[p]);
        EXPECT_LT(found.total_upper[p] - found.total_lower[p], 0.01);
    }
}

/// Of y = 1 + sum a_p u_p the index of p is a_p^2 / sum a^2, first-order and total.
TEST_F(SobolIndex, OfALinearFunctionIsThePartOfItsSquare) {
    const std::vector<double> slope{2.0, -3.0, 0.5, 0.0};
    const auto points = sobol_points(32, slope.size());
    const auto linear = [&](const std::vector<double> &unit) {
        double value = 1.0;
        for (std::size_t p = 0; p < slope.size(); ++p)
            value += slope[p] * unit[p];
        return value;
    };
    const auto constant = std::vector<double>(points.size(), 5.0);
    const auto found = sobol_indices(points, {values_at(points, linear), constant}, {{0, 3}});
    for (std::size_t p = 0; p < slope.size(); ++p) {
        EXPECT_NEAR(found[0].first[p], slope[p] * slope[p] / 13.25, 1e-10);
        EXPECT_NEAR(found[0].total[p], slope[p] * slope[p] / 13.25, 1e-10);
        EXPECT_EQ(found[1].total[p], 0.0) << "of what does not vary";
    }
    EXPECT_NEAR(found[0].group_total[0], 4.0 / 13.25, 1e-10);
}

/// What cannot be explained, such as a die, is said.
TEST_F(SobolIndex, SaysWhatAPolynomialDoesNotExplain) {
    const auto points = sobol_points(64, 2);
    const auto noise = [&](const std::vector<double> &unit) { return std::sin(1e4 * unit[0]) + unit[1]; };
    const auto found = sobol_indices(points, {values_at(points, noise)}, {{0}}).front();
    EXPECT_GT(found.unexplained, 0.3);
    for (std::size_t p = 0; p < 2; ++p)
        EXPECT_GE(found.total[p], found.first[p]);
}

TEST_F(SobolIndex, HasPointsThatMorePointsBeginWith) {
    const auto few = sobol_points(5, 3), many = sobol_points(8, 3);
    ASSERT_EQ(many.size(), 8u);
    for (std::size_t s = 0; s < few.size(); ++s)
        EXPECT_EQ(few[s], many[s]);
}

} // namespace
} // namespace livermark::studies
