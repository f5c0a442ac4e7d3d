#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <vector>

#include "core/tool/ball_contact.hpp"
#include "interactive/method.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "tests/interactive/moving_scene.hpp"
#include "tests/oracles/slow_methods.hpp"
#include "tests/samples/covered_bodies.hpp"
#include "tests/samples/touched_block.hpp"

namespace livermark {
namespace {

using core::Vector3;
using interactive::Field;

/// A method under a ball, frame by frame until it lets go.
struct UnderBall {
    std::vector<Field> displacement; ///< shape (3, N) [m]
    std::vector<Vector3> impulse;    ///< of the body on the ball [N s]
};

/// Steps of a frame, and iterations of each.
struct Effort {
    int steps, iterations;
};

/// Small steps; few long ones where a step solves a linear system; as many explicit ones as are stable.
Effort effort_of(const interactive::Method &method, const interactive::Simulation &simulation, double frame) {
    if (method.is_explicit) {
        const double longest = msm::default_safety_factor * simulation.critical_time_step();
        return {.steps = 1, .iterations = static_cast<int>(std::ceil(frame / longest))};
    }
    return method.name == "corotational_implicit" ? Effort{2, 40} : Effort{20, 2};
}

UnderBall move_under_ball(const interactive::Method &method, const core::Problem &problem,
                          const interactive::Scene &scene) {
    const auto simulation = method.prepare(scene);
    const auto &motion = *problem.load_case.tool;
    const auto &touching = *problem.load_case.touching;
    const auto [steps, iterations] = effort_of(method, *simulation, motion.frame_interval);
    const auto ball = std::make_shared<core::BallContact>(core::touched_facets(*problem.body, problem.load_case),
                                                          core::contact_divisions(*problem.body, problem.load_case),
                                                          touching.shape, touching.friction);
    EXPECT_TRUE(simulation->touch(ball));
    const Field rest = simulation->positions();
    const double step = motion.frame_interval / steps;
    const auto centre = [&](double time) { return core::ball_centre(touching, motion, time); };
    UnderBall moved;
    for (int frame = 1; motion.time_of(frame) < motion.release_at; ++frame) {
        const double start = motion.time_of(frame - 1);
        ball->set_way(centre(start), centre(start + motion.frame_interval));
        ball->look_around([&](int node) -> Vector3 { return simulation->positions().col(node); });
        for (int s = 0; s < steps; ++s) {
            ball->set_way(centre(start + s * step), centre(start + (s + 1) * step));
            simulation->step(step, iterations);
        }
        moved.displacement.emplace_back(simulation->positions() - rest);
        moved.impulse.push_back(ball->take_impulse());
    }
    return moved;
}

class TouchingSteps : public testing::TestWithParam<std::string> {};

/// Press and slide with friction.
void expect_as_in_double_precision(const std::string &name, const core::Problem &problem) {
    interactive::Scene scene{.body = problem.body,
                             .node_mass = msm::lumped_masses(*problem.body),
                             .constrained_nodes = {},
                             .mass_damping = problem.load_case.tool->mass_damping};
    const auto conditions = msm::nodal_conditions(problem, scene.node_mass);
    for (int i = 0; i < problem.body->mesh.num_nodes(); ++i)
        if (!conditions.displacement[i].hasNaN())
            scene.constrained_nodes.push_back(i);
    const auto fast = move_under_ball(interactive::find_method(name), problem, scene);
    const auto slow = move_under_ball(tests::slow_method(name), problem, scene);
    ASSERT_EQ(fast.displacement.size(), 11U);
    double squares = 0.0, all = 0.0, largest = 0.0;
    for (std::size_t frame = 0; frame < fast.displacement.size(); ++frame) {
        squares += (fast.impulse[frame] - slow.impulse[frame]).squaredNorm();
        all += slow.impulse[frame].squaredNorm();
        largest = std::max(largest, slow.impulse[frame].norm());
    }
    EXPECT_GT(largest, 0.02 * problem.load_case.tool->frame_interval); // 20 mN
    EXPECT_LT(std::sqrt(squares / all), 0.01);
    EXPECT_GT(squares, 0.0) << "both are the same code";
    for (const std::size_t frame : {std::size_t{5}, std::size_t{10}})
        EXPECT_LT((fast.displacement[frame] - slow.displacement[frame]).norm(), 2e-3 * slow.displacement[frame].norm());
}

tests::TouchedBlock rough_block() {
    tests::TouchedBlock block;
    block.friction = 0.3;
    return block;
}

TEST_P(TouchingSteps, MoveAsInDoublePrecision) {
    expect_as_in_double_precision(GetParam(), tests::slid_block(rough_block()));
}

INSTANTIATE_TEST_SUITE_P(All, TouchingSteps, testing::ValuesIn(tests::method_names([](const auto &method) {
                             return method.knows_contact;
                         })),
                         [](const auto &of) { return of.param; });

/// Nodes give way as their own stiffness says, also that of springs.
TEST(TouchingDescent, MovesAsInDoublePrecisionWithACapsule) {
    auto problem = tests::slid_block(rough_block());
    problem.body = tests::covered::with_capsule(problem.body);
    expect_as_in_double_precision("vertex_block_descent", problem);
}

} // namespace
} // namespace livermark
