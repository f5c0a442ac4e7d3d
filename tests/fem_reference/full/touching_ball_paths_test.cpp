#include <cmath>
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
