#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/tool/ball_contact.hpp"
#include "core/tool/tool_motion.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/motion/moving_method.hpp"
#include "tests/samples/touched_block.hpp"

namespace livermark {
namespace {

using core::Vector3;

/// What a method does under a ball, frame by frame.
struct TouchedMotion {
    std::vector<Vector3> force;                                ///< (K) of the body on the ball [N]
    std::vector<std::vector<Vector3>> displacement;            ///< (K, N) [m]
    double deepest = -std::numeric_limits<double>::infinity(); ///< inside the ball, as long as it is there [m]
};

constexpr models::Effort small_steps{.steps = 20, .iterations = 2};
/// Of what solves a linear system in each step.
constexpr models::Effort few_steps{.steps = 2, .iterations = 40};

models::Effort effort_for(const std::string &name) {
    return name == "corotational_implicit" ? few_steps : small_steps;
}

TouchedMotion move_under_ball(const std::string &name, const core::Problem &problem,
                              std::optional<models::Effort> effort = {}) {
    const auto methods = models::all_moving_methods();
    const auto method = std::ranges::find(methods, name, &models::MovingMethod::name);
    const auto body = method->under_tool(problem);
    const auto &motion = *problem.load_case.tool;
    const auto &mesh = problem.body->mesh;
    const auto used = body->least_effort().value_or(effort.value_or(effort_for(name)));
    body->prepare_for(used);
    TouchedMotion result;
    const auto points = core::facet_points(core::contact_divisions(*problem.body, problem.load_case));
    const auto record = [&] {
        result.force.push_back(body->tool_force());
        result.displacement.push_back(body->displacement());
    };
    record();
    for (int frame = 1; frame <= motion.num_frames; ++frame) {
        if (frame == core::last_record_held(motion) + 1)
            body->let_go();
        body->advance({.start = motion.time_of(frame - 1)}, used);
        record();
        if (frame > core::last_record_held(motion))
            continue;
        const auto &ball = *problem.load_case.touching;
        const auto centre = core::ball_centre(ball, motion, motion.time_of(frame));
        for (const auto &facet : core::touched_facets(*problem.body, problem.load_case))
            for (const auto &point : points) {
                Vector3 from_centre = -centre;
                for (std::size_t k = 0; k < 3; ++k)
                    from_centre +=
                        point.shape[k] * (mesh.points[facet.nodes[k]] + result.displacement.back()[facet.nodes[k]]);
                result.deepest = std::max(result.deepest, -core::gap_to(ball.shape, from_centre).size);
            }
    }
    return result;
}

std::vector<std::string> methods_with_contact() {
    std::vector<std::string> names;
    for (const auto &method : models::all_moving_methods())
        if (method.knows_contact)
            names.push_back(method.name);
    return names;
}

double difference(const std::vector<Vector3> &a, const std::vector<Vector3> &b) {
    double squares = 0.0, all = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        squares += (a[i] - b[i]).squaredNorm();
        all += b[i].squaredNorm();
    }
    return std::sqrt(squares / all);
}

/// Of the records of the slide: force along x over that along z.
double slide_ratio(const core::Problem &problem, const TouchedMotion &moved) {
    const auto &motion = *problem.load_case.tool;
    Vector3 sum = Vector3::Zero();
    for (int k = 0; k < motion.num_records(); ++k)
        if (motion.time_of(k) > motion.slide_from && motion.time_of(k) < motion.slide_until)
            sum += moved.force[k];
    return -sum.x() / sum.z();
}

tests::TouchedBlock with_friction(double friction) {
    tests::TouchedBlock block;
    block.friction = friction;
    return block;
}

class ShapesInMotion : public testing::TestWithParam<core::ToolShape> {};

/// Points of facets are inside the tool by what the penalty lets them: a sixth of the press on this mesh below a ball,
/// and at most half of it at the edges of a plate, where pressure has its peak.
TEST_P(ShapesInMotion, KeepFacetsOutAndArePushedOnly) {
    auto block = with_friction(0.0);
    block.shape = GetParam();
    for (const double friction : {0.0, 0.3}) {
        block.friction = friction;
        const auto problem = tests::slid_block(block);
        const auto &motion = *problem.load_case.tool;
        for (const auto &name : methods_with_contact()) {
            const auto moved = move_under_ball(name, problem);
            EXPECT_LT(moved.deepest, (block.shape.is_plate() ? 0.5 : 0.2) * problem.load_case.touching->press.norm())
                << name;
            EXPECT_GT(moved.deepest, 0.0) << name; // it does touch
            EXPECT_EQ(moved.force.front(), Vector3::Zero()) << name;
            for (int k = 1; k < motion.num_records(); ++k)
                EXPECT_GE(moved.force[k].z(), 0.0) << name << " in frame " << k;
            EXPECT_GT(moved.force[core::last_record_held(motion)].z(), 0.02) << name;
            for (int k = core::last_record_held(motion) + 1; k < motion.num_records(); ++k)
                EXPECT_EQ(moved.force[k], Vector3::Zero()) << name;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(TouchingMethods, ShapesInMotion,
                         testing::Values(core::ToolShape(0.02), tests::pressing_plate(core::ToolFace::round),
                                         tests::pressing_plate(core::ToolFace::square)),
                         [](const auto &shape) { return std::string(core::to_string(shape.param.face)); });

/// A ball that goes away again takes nothing with it.
TEST(TouchingMethods, DoNotStickToABallThatGoesAway) {
    auto problem = tests::slid_block(with_friction(0.3));
    auto &motion = *problem.load_case.tool;
    motion.slide = {0.0, 0.0, 8e-3}; // out of the body, by more than it came in
    motion.mass_damping = 20.0;
    motion.slide_until = 0.3;
    motion.release_at = 0.6;
    motion.num_frames = 30;
    for (const auto &name : methods_with_contact()) {
        const auto moved = move_under_ball(name, problem);
        double largest = 0.0;
        for (const auto &force : moved.force) {
            EXPECT_GE(force.z(), 0.0) << name;
            largest = std::max(largest, force.norm());
        }
        EXPECT_GT(largest, 0.02) << name;
        EXPECT_EQ(moved.force[20], Vector3::Zero()) << name;
        double deformed = 0.0;
        for (const auto &u : moved.displacement.back())
            deformed = std::max(deformed, u.norm());
        EXPECT_LT(deformed, 3e-4) << name; // of 3 mm
    }
}

/// Where points stick and slip in turn from solution to solution, a long step ends with a tenth of the force missing.
TEST(TouchingMethods, FeelInOneLongStepTheFrictionOfShortOnes) {
    const auto problem = tests::slid_block(with_friction(0.3));
    const auto &motion = *problem.load_case.tool;
    const auto at_the_end_of_the_press = [&](int steps) {
        const auto moved =
            move_under_ball("corotational_implicit", problem, models::Effort{.steps = steps, .iterations = 40});
        std::size_t k = 0;
        while (motion.time_of(static_cast<int>(k)) < motion.slide_from)
            ++k;
        return moved.force[k];
    };
    const auto one = at_the_end_of_the_press(1), eight = at_the_end_of_the_press(8);
    EXPECT_NEAR(one.z() / eight.z(), 1.0, 0.03);
}

TEST(TouchingMethods, FeelFrictionWithinItsCone) {
    const auto none = tests::slid_block(with_friction(0.0), 8e-3), some = tests::slid_block(with_friction(0.2), 8e-3);
    for (const auto &name : methods_with_contact()) {
        const double smooth = slide_ratio(none, move_under_ball(name, none));
        const double rough = slide_ratio(some, move_under_ball(name, some));
        EXPECT_LT(std::abs(smooth), 0.06) << name; // the shape of what it sinks into
        EXPECT_LT(rough, smooth + 0.21) << name;
        EXPECT_GT(rough, smooth + 0.1) << name;
    }
}

/// Where the ball stays long enough, springs come to rest under it as in their equilibrium.
TEST(TouchingMethods, SpringsComeToRestInTheirStaticSolution) {
    auto problem = tests::slid_block();
    auto &motion = *problem.load_case.tool;
    motion.slide.setZero();
    motion.release_at = motion.slide_until = 1.0;
    motion.num_frames = 50;
    auto at_rest = problem;
    at_rest.load_case.tool.reset();
    at_rest.load_case.path = {0.5, 1.0};
    int num_compared = 0;
    for (const char *const name : {"lloyd", "nodal_neo_hookean"}) {
        const auto moved = move_under_ball(name, problem);
        for (const auto &model : models::all_models())
            if (model.name == name) {
                const auto solution = model.solve(at_rest);
                ++num_compared;
                EXPECT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
                EXPECT_LT((moved.force.back() + solution.reaction.back()).norm(), 1e-4 * moved.force.back().norm());
                EXPECT_LT(difference(moved.displacement.back(), solution.displacement), 1e-4) << name;
            }
    }
    EXPECT_EQ(num_compared, 2);
}

/// All of them, so that no method is left out where the tool touches.
TEST(TouchingMethods, AreAllMethods) {
    EXPECT_EQ(methods_with_contact().size(), models::all_moving_methods().size());
}

/// Where the ball stays, methods on linear tetrahedra come to about the same force: their energies differ by less than
/// contact would if it were another.
TEST(TouchingMethods, ImplicitMethodsAreAsStiffUnderABallAsExplicitOnes) {
    auto problem = tests::slid_block(with_friction(0.3));
    auto &motion = *problem.load_case.tool;
    motion.slide.setZero();
    motion.release_at = motion.slide_until = 0.4;
    motion.num_frames = 20;
    const double expected = move_under_ball("vertex_block_descent", problem).force.back().norm();
    for (const char *const name : {"corotational_implicit", "projective_dynamics"})
        EXPECT_NEAR(move_under_ball(name, problem).force.back().norm() / expected, 1.0, 0.15) << name;
}

TEST(TouchingMethods, GiveTheSameBitsAgain) {
    const auto problem = tests::slid_block(with_friction(0.3));
    for (const auto &name : methods_with_contact())
        EXPECT_EQ(move_under_ball(name, problem).force, move_under_ball(name, problem).force) << name;
}

} // namespace
} // namespace livermark
