#include <cmath>
#include <gtest/gtest.h>

#include "core/mesh/facet_points.hpp"

namespace livermark {
namespace {

double power(double base, int exponent) {
    return exponent == 0 ? 1.0 : std::pow(base, exponent);
}

double factorial(int n) {
    return std::tgamma(n + 1.0);
}

/// The mean of a^i b^j c^k over a triangle is 2 i! j! k! / (i + j + k + 2)!.
TEST(FacetPoints, IntegratePolynomialsUpToTheFifthDegree) {
    for (const int divisions : {1, 2, 3, 5})
        for (int i = 0; i <= 5; ++i)
            for (int j = 0; i + j <= 5; ++j)
                for (int k = 0; i + j + k <= 5; ++k) {
                    double mean = 0.0;
                    for (const auto &point : core::facet_points(divisions))
                        mean +=
                            point.part * power(point.shape[0], i) * power(point.shape[1], j) * power(point.shape[2], k);
                    const double expected = 2.0 * factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 2);
                    EXPECT_NEAR(mean, expected, 1e-14);
                }
}

TEST(FacetPoints, LieInsideAndAreSevenInEachPart) {
    for (const int divisions : {1, 2, 4}) {
        const auto points = core::facet_points(divisions);
        EXPECT_EQ(points.size(), 7U * static_cast<std::size_t>(divisions * divisions));
        for (const auto &point : points) {
            EXPECT_GT(point.part, 0.0);
            for (const double shape : point.shape)
                EXPECT_GT(shape, 0.0);
        }
    }
}

} // namespace
} // namespace livermark
