#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <span>
#include <vector>

#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/hyperelastic/surface/touching_ball.hpp"
#include "tests/fem_reference/touched_block.hpp"

namespace livermark {

namespace {

using core::Vector3;
using hyperelastic::Elements;
using hyperelastic::TouchingBall;

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
        const auto problem = tests::touched_block(0.3, {0.0006, 0.0, -0.002});
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

/// The expectation is wrong by the square of the change only, and where nothing changes the tangent is the exact one.
TEST(TouchingBall, ExpectsThePressureThatItsTangentGives) {
    const auto problem = tests::touched_block(0.3, {0.0006, 0.0, -0.002});
    const Elements elements(problem.body, 2, fem_reference::Formulation::displacement,
                            hyperelastic::material_law("neo_hookean"), hyperelastic::TetrahedronRule::fourteen_points);
    const TouchingBall ball(elements.system(), *problem.body, problem.load_case, {.stiffness = 3.0});
    const auto centre = ball.tool().centre_at(1.0);
    std::mt19937 generator(5);
    std::uniform_real_distribution<double> some(-1.0, 1.0);
    std::vector<double> state(elements.num_displacements()), change(state.size()), there(state.size());
    for (std::size_t dof = 0; dof < state.size(); ++dof) {
        state[dof] = 1e-4 * some(generator);
        change[dof] = 1e-7 * some(generator);
        there[dof] = state[dof] + change[dof];
    }
    const auto before = ball.expected_pressure(centre, state), expected = ball.expected_pressure(centre, state, change),
               after = ball.expected_pressure(centre, there);
    ASSERT_EQ(before.size(), ball.num_points());
    double wrong = 0.0, changed = 0.0;
    for (std::size_t point = 0; point < before.size(); ++point) {
        wrong += std::abs(after[point] - expected[point]);
        changed += std::abs(after[point] - before[point]);
    }
    EXPECT_GT(changed, 0.0);
    EXPECT_LT(wrong, 1e-4 * changed);

    const auto product = [&](std::span<const double> of_curvature) {
        hyperelastic::SurfaceStiffness stiffness;
        ball.add_stiffness(centre, state, stiffness, of_curvature);
        std::vector<double> found(state.size(), 0.0);
        stiffness.add_product(change, found);
        return found;
    };
    EXPECT_EQ(product(before), product({}));
    EXPECT_NE(product(std::vector<double>(before.size(), 0.0)), product({}));
}

/// Forces balance; the surface does not go through the ball, and is not pulled.
TEST(TouchingBall, PressesWithWhatTheOtherSideHolds) {
    for (const double friction : {0.0, 0.3})
        for (const auto &kind : tests::hyperelastic_kinds) {
            const auto problem = tests::touched_block(friction, {0.0, 0.0, -0.006});
            const auto found = tests::touch(problem, kind, {0.5, 1.0});
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

} // namespace livermark
