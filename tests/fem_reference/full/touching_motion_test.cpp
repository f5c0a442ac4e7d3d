#include <algorithm>
#include <cstddef>
#include <gtest/gtest.h>
#include <numeric>

#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/hyperelastic/motion/tool_motion.hpp"
#include "tests/fem_reference/hyperelastic_bodies.hpp"

namespace livermark {

namespace {

using core::Vector3;

/// A block under a ball that sinks in within half a second, slides if it does, and is gone at the end.
core::Problem block_under_a_moving_ball(double friction, const Vector3 &slide) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.1, 0.06}, {3, 3, 2}), tests::soft_material);
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "z_min", Vector3::Zero());
    constexpr double radius = 0.04;
    load_case.regime = core::Regime::large;
    load_case.touching = core::TouchingTool{.radius = radius,
                                            .start = {0.05, 0.05, 0.06 + radius},
                                            .press = {0.0, 0.0, -0.005},
                                            .friction = friction,
                                            .constraint = load_case.num_constraints()};
    load_case.tool = core::ToolMotion{.constraint = load_case.touching->constraint,
                                      .press_until = 0.5,
                                      .slide = slide,
                                      .slide_from = 0.6,
                                      .slide_until = 1.1,
                                      .release_at = 1.2,
                                      .num_frames = 36,
                                      .frame_interval = 0.05,
                                      .mass_damping = 20.0};
    load_case.conditions.push_back({"touch", core::ConditionKind::touch});
    load_case.target_peak_displacement = 0.005;
    return {body, load_case};
}

core::ToolHistory moved(const core::Problem &problem, int steps_per_frame) {
    return hyperelastic::move_tool(problem, hyperelastic::material_law("neo_hookean"), 2, steps_per_frame,
                                   hyperelastic::TetrahedronRule::fourteen_points);
}

} // namespace

/// Pressed slowly and held, the body is where statics have it, under the same force; let go, it comes back.
TEST(TouchingMotion, ComesToRestWhereStaticsHaveIt) {
    const auto problem = block_under_a_moving_ball(0.0, Vector3::Zero());
    const auto history = moved(problem, 4);
    ASSERT_EQ(history.time.size(), 37U);
    auto still = problem;
    still.load_case.tool.reset();
    const auto rest = hyperelastic::solve(still, hyperelastic::material_law("neo_hookean"), {.degree = 2},
                                          {.fractions = {0.5, 1.0}, .tolerance = 1e-8});
    ASSERT_EQ(rest.solution.status, core::SolutionStatus::ok) << rest.solution.message;
    // The trapezoidal rule lets the force on a surface that touches go to and fro by up to 3 % while the tool rests.
    constexpr std::ptrdiff_t first_at_rest = 14, let_go = 25;
    const Vector3 expected = -rest.solution.reaction[1];
    const Vector3 found = std::accumulate(history.force.begin() + first_at_rest, history.force.begin() + let_go,
                                          Vector3(Vector3::Zero())) /
                          static_cast<double>(let_go - first_at_rest);
    EXPECT_LT((found - expected).norm(), 0.01 * expected.norm());
    EXPECT_EQ(history.force.back(), Vector3::Zero());
    const std::size_t num_nodes = problem.body->mesh.points.size();
    double left = 0.0;
    for (std::size_t node = 0; node < num_nodes; ++node)
        left = std::max(left, static_cast<double>(history.displacement[9 * num_nodes + node].norm()));
    EXPECT_LT(left, 0.001);
}

/// A ball that slides is held back by friction, in the steps as in statics.
TEST(TouchingMotion, SlidesAgainstFriction) {
    const auto history = moved(block_under_a_moving_ball(0.3, {0.01, 0.0, 0.0}), 8);
    ASSERT_EQ(history.time.size(), 37U);
    const Vector3 while_sliding = history.force[20]; // of the body on the tool
    EXPECT_LT(while_sliding.x(), -0.15 * while_sliding.z());
}

} // namespace livermark
