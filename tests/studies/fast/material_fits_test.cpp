#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "studies/experiments/experiments.hpp"

namespace livermark::studies {
namespace {

const core::Material fitted{1000.0, 5e3, 0.45};

/// A measurement of a material of 8 kPa and a ratio of 0.49.
double distance_from_known(const core::Material &material) {
    return 1e-3 * std::hypot(std::log(material.young_modulus / 8e3), 5.0 * (material.poisson_ratio - 0.49));
}

TEST(FittedMaterial, IsNearestToTheMeasurement) {
    const auto fit = fit_material("springs", fitted, true, distance_from_known);
    EXPECT_EQ(fit.model, "springs");
    EXPECT_NEAR(fit.young_modulus, 8e3, 0.01 * 8e3);
    EXPECT_NEAR(fit.poisson_ratio, 0.49, 0.001);
    EXPECT_LT(fit.error_of_modulus, fit.error);
    EXPECT_LT(fit.error_of_ratio, fit.error);
    EXPECT_NEAR(fit.error, distance_from_known(fitted), 1e-15);
}

TEST(FittedMaterial, HasNoModulusWhereOnlyDisplacementsAreGiven) {
    const auto fit = fit_material("springs", fitted, false, distance_from_known);
    EXPECT_TRUE(std::isnan(fit.young_modulus));
    EXPECT_NEAR(fit.poisson_ratio, 0.49, 0.001);
}

TEST(FittedMaterial, OfAModelWithoutASolutionIsNotKnown) {
    const auto fit = fit_material("lost", fitted, true,
                                  [](const core::Material &) { return std::numeric_limits<double>::infinity(); });
    EXPECT_TRUE(std::isnan(fit.young_modulus));
    EXPECT_TRUE(std::isnan(fit.poisson_ratio));
}

} // namespace
} // namespace livermark::studies
