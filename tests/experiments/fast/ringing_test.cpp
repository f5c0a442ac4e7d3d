#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <span>
#include <vector>

#include "experiments/ringing.hpp"
#include "tests/bad_input.hpp"

namespace livermark::experiments {
namespace {

using core::Vector3;

constexpr double interval = 0.01, tau = 2.0 * std::numbers::pi;

/// Two markers that ring about a place that creeps, the second half as far and the other way round in x.
MarkerMotion ringing(double frequency, double ratio, int num_records, double creep = 0.0, double delay = 0.0) {
    MarkerMotion motion{interval, 2, {}};
    for (int j = 0; j < num_records; ++j) {
        const double time = j * interval - delay;
        const double swing =
            time < 0.0 ? 1.0 : std::exp(-tau * frequency * ratio * time) * std::cos(tau * frequency * time);
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

TEST(FromTurningPoint, StartsBetweenRecords) {
    // Let go at the upper end at 0.1234 s, so at the lower one half a period later.
    const double frequency = 4.3, ratio = 0.05, delay = 0.1234;
    const auto recording = ringing(frequency, ratio, 200, 0.0, delay);
    auto shifted = recording; // displacements are from where a hand holds it
    for (int j = 0; j < recording.num_records(); ++j)
        for (int k = 0; k < 2; ++k)
            shifted.displacement[2 * j + k] -= recording.at(0, k);
    const auto found = from_turning_point(shifted, 100, "test");
    ASSERT_EQ(found.num_records(), 100);
    const auto fitted = fit_ringing(found, both);
    EXPECT_NEAR(fitted.frequency, frequency, 2e-3 * frequency);
    EXPECT_NEAR(fitted.ratio, ratio, 2e-3);
    const double before = found.at(0, 0).z();
    EXPECT_LT(before, found.at(1, 0).z()); // the lowest place
    EXPECT_NEAR(before, -0.008 * (1.0 + std::exp(-0.5 * tau * ratio)), 0.02e-3);
    tests::expect_input_error([&] { from_turning_point(shifted, 190, "test"); }, {"test", "190 records"});
}

} // namespace
} // namespace livermark::experiments
