#include "results/records/springs.hpp"

#include <gtest/gtest.h>
#include <limits>

namespace livermark::results {
namespace {

constexpr double any_step = std::numeric_limits<double>::infinity();

Stability with_limits(std::vector<IntegratorLimits> limits) {
    Stability stability;
    stability.body = "box";
    stability.spring_law = "lloyd";
    stability.limits = std::move(limits);
    return stability;
}

TEST(StepAdvice, IsAPartOfTheLongestStableStepOfSymplecticEuler) {
    auto stability = with_limits({{"runge_kutta_4", {2e-3}, {2e-3}}, {"symplectic_euler", {1e-3}, {5e-4}}});
    EXPECT_EQ(step_advice(stability, 0.8), "box, lloyd: take 0.8 ms, 0.8 of the longest stable step of "
                                           "symplectic_euler; with this damping 0.4 ms");
    stability.model = "nodal_springs";
    EXPECT_TRUE(step_advice(stability, 0.8).starts_with("box, nodal_springs: take 0.8 ms"));
}

TEST(StepAdvice, IsOfTheFirstIntegratorWithALongestStepWhereThatOneIsMissing) {
    const auto advice = step_advice(
        with_limits(
            {{"explicit_euler", {0.0}, {1e-4}}, {"implicit_euler", {any_step}, {any_step}}, {"heun", {1e-3}, {0.0}}}),
        0.5);
    EXPECT_EQ(advice, "box, lloyd: take 0.5 ms, 0.5 of the longest stable step of heun; with this damping no step");
}

TEST(StepAdvice, HasNoNumberWhereThereIsNoLongestStep) {
    EXPECT_EQ(step_advice(with_limits({{"implicit_euler", {any_step}, {any_step}}}), 0.8),
              "box, lloyd: take any step, none is unstable");
    EXPECT_NE(step_advice(with_limits({{"explicit_euler", {0.0}, {1e-4}}}), 0.8).find("take another integrator"),
              std::string::npos);
}

} // namespace
} // namespace livermark::results
