#include "msm/integrator.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace livermark {
namespace {

/// What a step makes of y = 1 where y' = z y.
double amplification(const std::vector<msm::ChebyshevStage> &stages, double z) {
    double before = 0.0, last = 0.0;
    for (const auto &stage : stages) {
        const double next =
            stage.mu * last + stage.nu * before + stage.mu_tilde * z * (1.0 + last) + stage.gamma_tilde * z;
        before = last;
        last = next;
    }
    return 1.0 + last;
}

/// T_s and its derivatives where x = cosh(t) > 1.
struct Chebyshev {
    double value, slope, curvature;

    Chebyshev(int s, double x) {
        const double t = std::acosh(x), root = std::sqrt(x * x - 1.0);
        value = std::cosh(s * t);
        slope = s * std::sinh(s * t) / root;
        curvature = (s * s * value - x * slope) / (x * x - 1.0);
    }
};

class ChebyshevStages : public testing::TestWithParam<std::tuple<int, double>> {
  protected:
    const int s = std::get<0>(GetParam());
    const double epsilon = std::get<1>(GetParam());
    const std::vector<msm::ChebyshevStage> stages = msm::chebyshev_stages(s, epsilon);
    const double w0 = 1.0 + epsilon / (s * s);
    const Chebyshev at_w0{s, w0};
    const double w1 = at_w0.slope / at_w0.curvature;
};

} // namespace

/// In closed form on the negative real axis, where w_0 + w_1 z lies between -1 and 1.
TEST_P(ChebyshevStages, HaveTheStabilityPolynomialOfTheMethod) {
    const double b = at_w0.curvature / (at_w0.slope * at_w0.slope);
    for (int i = 0; i <= 100; ++i) {
        const double angle = std::acos(-1.0) * i / 100.0;
        const double z = (std::cos(angle) - w0) / w1;
        EXPECT_NEAR(amplification(stages, z), 1.0 - b * at_w0.value + b * std::cos(s * angle), 1e-9) << z;
    }
}

TEST_P(ChebyshevStages, AreStableAsFarAsTheySay) {
    const double end = -(w0 + 1.0) / w1;
    for (int i = 1; i < 1000; ++i)
        EXPECT_LT(std::abs(amplification(stages, end * i / 1000.0)), 1.0) << i;
    EXPECT_GT(std::abs(amplification(stages, 1.5 * end)), 1.0);
    // The paper's estimate of how far that is.
    EXPECT_NEAR(-end, 2.0 / 3.0 * (s * s - 1) * (1.0 - 2.0 / 15.0 * epsilon), 0.02 * -end);
}

/// R(z) = exp(z) + O(z^3).
TEST_P(ChebyshevStages, AreOfSecondOrder) {
    const auto error = [&](double z) { return std::abs(amplification(stages, z) - std::exp(z)); };
    EXPECT_NEAR(std::log2(error(-0.02) / error(-0.01)), 3.0, 0.05);
    EXPECT_NEAR(stages.back().time, 1.0, 1e-13);
}

/// y' = t tells where in time the stages stand, and a method of second order is exact for it.
TEST_P(ChebyshevStages, StandWhereTheirTimesSay) {
    double before = 0.0, last = 0.0, time = 0.0;
    for (const auto &stage : stages) {
        EXPECT_GT(stage.time, time);
        const double next = stage.mu * last + stage.nu * before + stage.mu_tilde * time;
        before = last;
        last = next;
        time = stage.time;
    }
    EXPECT_NEAR(last, 0.5, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(All, ChebyshevStages,
                         testing::Combine(testing::Values(2, 3, 5, 8, 20), testing::Values(2.0 / 13.0, 0.5)));

} // namespace livermark
