#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <span>
#include <vector>

#include "experiments/ringing.hpp"

namespace livermark::experiments {
namespace {

using core::Vector3;

constexpr double interval = 0.01, tau = 2.0 * std::numbers::pi;

/// Two markers that ring about a place that creeps, the second half as far and the other way round in x.
MarkerMotion ringing(double frequency, double ratio, int num_records, double creep = 0.0) {
    MarkerMotion motion{interval, 2, {}};
    for (int j = 0; j < num_records; ++j) {
        const double time = j * interval;
        const double swing = std::exp(-tau * frequency * ratio * time) * std::cos(tau * frequency * time);
        for (const double part : {1.0, -0.5})
            motion.displacement.emplace_back(0.001 * part * swing, 0.0,
                                             -0.01 - creep * time + 0.008 * std::abs(part) * swing);
    }
    return motion;
}

constexpr std::array<int, 2> both{0, 1};

TEST(FitRinging, FindsFrequencyAndDamping) {
    for (const double frequency : {2.3, 7.7, 14.0})
        for (const double ratio : {0.0, 0.06, 0.2}) {
            const auto found = fit_ringing(ringing(frequency, ratio, 151), both);
            EXPECT_NEAR(found.frequency, frequency, 1e-4 * frequency) << ratio;
            EXPECT_NEAR(found.ratio, ratio, 1e-4) << frequency;
        }
}

TEST(FitRinging, IsNotMisledByCreep) {
    const auto found = fit_ringing(ringing(4.3, 0.05, 151, 0.002), both);
    EXPECT_NEAR(found.frequency, 4.3, 1e-3);
    EXPECT_NEAR(found.ratio, 0.05, 1e-3);
}

TEST(FitRinging, OfALostMotionIsNone) {
    auto motion = ringing(4.3, 0.05, 151);
    motion.displacement.back().x() = std::nan("");
    EXPECT_TRUE(std::isnan(fit_ringing(motion, both).frequency));
    EXPECT_TRUE(std::isnan(fit_ringing(ringing(4.3, 0.05, 5), both).ratio));
}

TEST(MeasuredRinging, IsAsUncertainAsItsRepeatsDiffer) {
    const std::vector repeats{ringing(4.2, 0.05, 151), ringing(4.4, 0.07, 151)};
    const auto found = measured_ringing(repeats, both);
    EXPECT_NEAR(found.value.frequency, 4.3, 1e-3);
    EXPECT_NEAR(found.value.ratio, 0.06, 1e-3);
    EXPECT_NEAR(found.frequency_uncertainty, 0.1, 0.01);
    EXPECT_NEAR(found.ratio_uncertainty, 0.01, 0.001);
    EXPECT_LT(measured_ringing(std::span(repeats).first(1), both).frequency_uncertainty, 1e-3);
}

TEST(Swings, FadeAsTheDampingSays) {
    const double ratio = 0.05, frequency = 4.3;
    const auto found = swings(ringing(frequency, ratio, 151), both, frequency, 4);
    const double fade = std::exp(-0.5 * tau * ratio); // from one turning point to the next
    double reach = 0.0075 * 0.8;                      // mean of both markers
    for (const double swing : found) {
        EXPECT_NEAR(swing, 0.5 * reach * (1.0 + fade), 0.005 * reach);
        reach *= fade;
    }
    EXPECT_TRUE(std::isnan(swings(ringing(frequency, ratio, 40), both, frequency, 4).back())); // over before
}

} // namespace
} // namespace livermark::experiments
