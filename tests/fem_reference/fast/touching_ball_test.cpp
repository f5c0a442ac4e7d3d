#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/hyperelastic/surface/touching_ball.hpp"
#include "tests/fem_reference/hyperelastic_bodies.hpp"

namespace livermark {

namespace {

using core::Vector3;
using hyperelastic::Elements;
using hyperelastic::TouchingBall;

const Vector3 touched_size{0.1, 0.1, 0.06};

/// A block that stands on its bottom; a ball comes from above.
core::Problem touched_block(double friction, const Vector3 &press, const Vector3 &slide = Vector3::Zero()) {
    const auto body = tests::make_body(tests::shaken_box_mesh(touched_size, {3, 3, 2}), tests::soft_material);
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "z_min", Vector3::Zero());
    constexpr double radius = 0.04;
    load_case.touching = core::TouchingTool{.radius = radius,
                                            .start = {0.047, 0.052, touched_size.z() + radius},
                                            .press = press,
                                            .slide = slide,
                                            .friction = friction,
                                            .constraint = static_cast<int>(load_case.constraint_names.size())};
    load_case.constraint_names.emplace_back("touch");
    load_case.regime = core::Regime::large;
    return {body, load_case};
}

hyperelastic::PathSolution touch(const core::Problem &problem, const hyperelastic::Discretisation &kind,
                                 const std::vector<double> &fractions) {
    return hyperelastic::solve(problem, hyperelastic::material_law("neo_hookean"), kind,
                               {.fractions = fractions, .tolerance = 1e-9});
}

std::vector<double> differences(const TouchingBall &ball, const std::vector<double> &at,
                                const std::vector<double> &direction, double step) {
    std::vector<double> slope(at.size(), 0.0);
    for (const double sign : {1.0, -1.0}) {
        auto there = at;
        for (std::size_t dof = 0; dof < at.size(); ++dof)
            there[dof] += sign * step * direction[dof];
        std::vector<double> force(at.size(), 0.0);
        ball.add_forces(ball.tool().centre_at(1.0), there, force);
        for (std::size_t dof = 0; dof < at.size(); ++dof)
            slope[dof] -= sign * force[dof] / (2.0 * step);
    }
    return slope;
}

} // namespace

/// Where some points stick, others slip, and multipliers are not zero.
TEST(TouchingBall, StiffnessIsTheDerivativeOfItsForces) {
    for (const int degree : {1, 2}) {
        const auto problem = touched_block(0.3, {0.0006, 0.0, -0.002});
        const Elements elements(problem.body, degree, fem_reference::Formulation::displacement,
                                hyperelastic::material_law("neo_hookean"),
                                hyperelastic::TetrahedronRule::fourteen_points);
        // Soft, so that no pressure is beyond what the stiffness takes.
        TouchingBall ball(elements.system(), *problem.body, problem.load_case, {.stiffness = 3.0});
        std::mt19937 generator(3);
        std::uniform_real_distribution<double> some(-1.0, 1.0);
        std::vector<double> state(elements.num_displacements()), direction(elements.num_displacements());
        for (std::size_t dof = 0; dof < state.size(); ++dof) {
            state[dof] = 1e-4 * some(generator);
            direction[dof] = some(generator);
        }
        ball.augment(ball.tool().centre_at(0.5), state);
        const auto sums = ball.sums(ball.tool().centre_at(1.0), state);
        ASSERT_GT(sums.slipping_area, 0.0);
        ASSERT_LT(sums.slipping_area, sums.area);
        hyperelastic::SurfaceStiffness stiffness;
        ball.add_stiffness(ball.tool().centre_at(1.0), state, stiffness);
        auto matrix = elements.zero_tangent();
        std::ranges::fill(matrix.stiffness.below, fem_reference::Block<double>{});
        std::ranges::fill(matrix.stiffness.diagonal, fem_reference::Block<double>{});
        stiffness.add_to(matrix.stiffness);
        std::vector<double> found(state.size());
        matrix.stiffness.multiply(std::span<const double>(direction), std::span<double>(found));
        stiffness.add_product(direction, found);
        const auto slope = differences(ball, state, direction, 1e-9);
        double difference = 0.0, size = 0.0;
        for (std::size_t dof = 0; dof < state.size(); ++dof) {
            difference += (found[dof] - slope[dof]) * (found[dof] - slope[dof]);
            size += slope[dof] * slope[dof];
        }
        EXPECT_GT(size, 0.0);
        EXPECT_LT(std::sqrt(difference / size), 1e-5);
    }
}

/// Forces balance; the surface does not go through the ball, and is not pulled.
TEST(TouchingBall, PressesWithWhatTheOtherSideHolds) {
    for (const double friction : {0.0, 0.3})
        for (const auto &kind : tests::hyperelastic_kinds) {
            const auto problem = touched_block(friction, {0.0, 0.0, -0.006});
            const auto found = touch(problem, kind, {0.5, 1.0});
            ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
            const auto &ball = *problem.load_case.touching;
            const Vector3 held = found.solution.reaction[0], pressed = found.solution.reaction[1];
            EXPECT_LT(pressed.z(), 0.0);
            EXPECT_LT((held + pressed).norm(), 1e-6 * pressed.norm());
            EXPECT_LT(found.points[0].reaction[1].norm(), pressed.norm());
            double nearest = 1.0;
            for (std::size_t node = 0; node < problem.body->mesh.points.size(); ++node)
                nearest = std::min(
                    nearest,
                    (problem.body->mesh.points[node] + found.solution.displacement[node] - ball.centre_at(1.0)).norm());
            EXPECT_GT(nearest, ball.radius - 1e-4);
        }
}

/// Every point that the ball drags along is on the cone of friction, and so is their sum where the surface is flat.
TEST(TouchingBall, SlidesWithCoulombsForce) {
    const auto problem = touched_block(0.3, {0.0, 0.0, -0.003}, {0.02, 0.0, 0.0});
    const auto found = touch(problem, {.degree = 2}, {0.25, 0.5, 0.625, 0.75, 0.875, 1.0});
    ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
    const auto along = [&](std::size_t point) {
        const auto &force = found.points[point].reaction[1];
        return force.x() / -force.z();
    };
    EXPECT_GT(along(2), 0.1);
    // The normals lean by half the slope of the contact, at most.
    EXPECT_NEAR(along(5), 0.3, 0.06);
    const auto smooth = touch(touched_block(0.0, {0.0, 0.0, -0.003}, {0.02, 0.0, 0.0}), {.degree = 2}, {0.5, 1.0});
    EXPECT_NEAR(smooth.points[1].reaction[1].x() / smooth.points[1].reaction[1].z(), 0.0, 0.06);
}

/// Without augmentation the ball sinks in by what the penalty lets it, so the force errs by 1 / penalty; with it a soft
/// penalty will do.
TEST(TouchingBall, ForceConvergesWithThePenaltyAndAugmentationReplacesIt) {
    const auto problem = touched_block(0.0, {0.0, 0.0, -0.004});
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
