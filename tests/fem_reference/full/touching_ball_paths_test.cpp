#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/hyperelastic/surface/touching_ball.hpp"
#include "tests/fem_reference/touched_block.hpp"

namespace livermark {

namespace {

using core::Vector3;
using hyperelastic::Elements;
using hyperelastic::TouchingBall;

} // namespace

/// Every point that the ball drags along is on the cone of friction, and so is their sum where the surface is flat.
TEST(TouchingBall, SlidesWithCoulombsForce) {
    const auto problem = tests::touched_block(0.3, {0.0, 0.0, -0.003}, {0.02, 0.0, 0.0});
    const auto found = tests::touch(problem, {.degree = 2}, {0.25, 0.5, 0.625, 0.75, 0.875, 1.0});
    ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
    const auto along = [&](std::size_t point) {
        const auto &force = found.points[point].reaction[1];
        return force.x() / -force.z();
    };
    EXPECT_GT(along(2), 0.1);
    // The normals lean by half the slope of the contact, at most.
    EXPECT_NEAR(along(5), 0.3, 0.06);
    const auto smooth =
        tests::touch(tests::touched_block(0.0, {0.0, 0.0, -0.003}, {0.02, 0.0, 0.0}), {.degree = 2}, {0.5, 1.0});
    EXPECT_NEAR(smooth.points[1].reaction[1].x() / smooth.points[1].reaction[1].z(), 0.0, 0.06);
}

/// A ball of one and a half edges sinks in by most of its radius, with friction, in three load steps. Each of them is
/// found, though points begin to touch, to stick and to slip again and again.
TEST(TouchingBall, NewtonsMethodFollowsADeepPressInFewIterations) {
    const Vector3 size(0.048, 0.048, 0.032);
    const auto body = tests::make_body(tests::shaken_box_mesh(size, {6, 6, 4}), {1060.0, 5000.0, 0.45});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "z_min", Vector3::Zero());
    constexpr double radius = 0.012;
    load_case.touching = core::TouchingTool{.radius = radius,
                                            .start = {0.0231, 0.0253, size.z() + radius},
                                            .press = {0.0, 0.0, -0.01},
                                            .friction = 0.3,
                                            .constraint = load_case.num_constraints()};
    load_case.conditions.push_back({"touch", core::ConditionKind::touch});
    load_case.regime = core::Regime::large;
    const auto found = tests::touch({body, load_case}, {.degree = 2, .formulation = fem_reference::Formulation::mixed},
                                    {0.1, 0.3, 1.0});
    ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
    std::size_t num_solves = 0;
    for (const auto &step : found.steps) {
        EXPECT_TRUE(step.converged);
        num_solves += step.linear_iterations.size();
    }
    fmt::print("{} load steps and augmentations, {} linear solves\n", found.steps.size(), num_solves);
    EXPECT_LT(num_solves, 70);
}

/// Without augmentation the ball sinks in by what the penalty lets it, so the force errs by 1 / penalty; with it a soft
/// penalty will do.
TEST(TouchingBall, ForceConvergesWithThePenaltyAndAugmentationReplacesIt) {
    const auto problem = tests::touched_block(0.0, {0.0, 0.0, -0.004});
    const Elements elements(problem.body, 2, fem_reference::Formulation::displacement,
                            hyperelastic::material_law("neo_hookean"), hyperelastic::TetrahedronRule::fourteen_points);
    const auto conditions = fem_reference::dof_conditions(problem.load_case, elements.system());
    const auto force = [&](const hyperelastic::ContactSettings &settings) {
        TouchingBall ball(elements.system(), *problem.body, problem.load_case, settings);
        const auto found =
            hyperelastic::follow(elements, conditions, 2, {}, {.fractions = {0.5, 1.0}, .tolerance = 1e-9}, &ball);
        EXPECT_EQ(found.status, core::SolutionStatus::ok) << found.message;
        return found.points.back().touch.force.norm();
    };
    const auto penalty = [&](double stiffness) { return force({.stiffness = stiffness, .max_augmentations = 0}); };
    const double a = penalty(10.0), b = penalty(20.0), c = penalty(40.0), limit = penalty(4000.0);
    EXPECT_LT(a, b);
    EXPECT_LT(b, c);
    EXPECT_NEAR((limit - a) / (limit - b), 2.0, 0.4);
    EXPECT_NEAR(force({.stiffness = 20.0, .sunk_in = 1e-4, .max_augmentations = 8}), limit, 0.01 * limit);
    EXPECT_LT(std::abs(force({.stiffness = 20.0, .sunk_in = 1e-4, .max_augmentations = 8}) - limit),
              0.2 * std::abs(b - limit));
}

} // namespace livermark
