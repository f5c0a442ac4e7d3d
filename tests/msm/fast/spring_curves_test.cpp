#include "msm/spring_law.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace livermark {
namespace {

class EverySpringCurve : public testing::TestWithParam<msm::SpringCurve> {
  protected:
    msm::ForceCurve curve = GetParam().curve;
};

TEST_P(EverySpringCurve, IsHookesNearRest) {
    EXPECT_NEAR(curve.energy(1.0), 0.0, 1e-16);
    EXPECT_NEAR(curve.force(1.0), 0.0, 1e-16);
    EXPECT_NEAR(curve.slope(1.0), 1.0, 1e-15);
}

TEST_P(EverySpringCurve, HasForcesThatAreTheDerivativeOfItsEnergyAndSlopesOfItsForces) {
    const double step = 1e-5;
    for (const double stretch : {0.4, 0.8, 1.0, 1.3, 2.0}) {
        const auto slope_of = [&](double (*function)(double)) {
            return (function(stretch + step) - function(stretch - step)) / (2.0 * step);
        };
        const double scale = 1.0 + std::abs(curve.slope(stretch));
        EXPECT_NEAR(slope_of(curve.energy), curve.force(stretch), 1e-8 * scale) << stretch;
        EXPECT_NEAR(slope_of(curve.force), curve.slope(stretch), 1e-7 * scale) << stretch;
    }
}

TEST_P(EverySpringCurve, PullsWhereItIsLongAndPushesWhereItIsShort) {
    EXPECT_LT(curve.force(0.9), 0.0);
    EXPECT_GT(curve.force(1.1), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Curves, EverySpringCurve, testing::ValuesIn(msm::all_spring_curves()),
                         [](const auto &info) { return info.param.name; });

/// The mean over all directions of the energy of springs with sum k l0^2 = 15 mu V, over mu V.
double energy_in_all_directions(const msm::ForceCurve &curve, const Eigen::Matrix3d &deformation) {
    constexpr int num_heights = 400, num_angles = 400; // the midpoint rule is exact enough for smooth functions
    double sum = 0.0;
    for (int i = 0; i < num_heights; ++i)
        for (int j = 0; j < num_angles; ++j) {
            const double z = -1.0 + (2.0 * i + 1.0) / num_heights;
            const double angle = 2.0 * std::numbers::pi * (j + 0.5) / num_angles;
            const double radius = std::sqrt(1.0 - z * z);
            sum += curve.energy(
                (deformation * Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), z)).norm());
        }
    return 15.0 * sum / (num_heights * num_angles);
}

/// A material out of central springs, at any deformation.
TEST(SpringCurveNeoHookean, IsANeoHookeanMaterialInAllDirectionsTogether) {
    Eigen::Matrix3d sheared, pressed, pulled;
    sheared << 1.0, 0.6, 0.0, 0.0, 1.0, 0.1, 0.0, 0.0, 1.0;
    pressed << 0.6, 0.0, 0.1, 0.0, 1.2, 0.0, 0.2, 0.0, 1.1;
    pulled << 1.7, 0.2, 0.0, 0.0, 0.9, 0.0, 0.0, 0.3, 1.3;
    const auto curves = msm::all_spring_curves();
    const auto curve = std::ranges::find(curves, "neo_hookean", &msm::SpringCurve::name);
    ASSERT_NE(curve, curves.end());
    for (const auto &deformation : {sheared, pressed, pulled}) {
        const double volume = deformation.determinant();
        const double expected = 0.5 * (deformation.squaredNorm() - 3.0) + 1.0 / volume - 1.0;
        EXPECT_NEAR(energy_in_all_directions(curve->curve, deformation), expected, 1e-5 * expected);
        EXPECT_GT(std::abs(energy_in_all_directions(msm::hooke, deformation) - expected), 1e-2 * expected);
    }
}

} // namespace
} // namespace livermark
