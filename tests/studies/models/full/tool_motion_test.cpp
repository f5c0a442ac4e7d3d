#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/support/input_error.hpp"
#include "core/tool/ball_contact.hpp"
#include "core/tool/tool_motion.hpp"
#include "fem_reference/hyperelastic/motion.hpp"
#include "msm/elastic_body.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/motion/moving_method.hpp"
#include "tests/samples/tool_block.hpp"
#include "tests/samples/touched_block.hpp"

namespace livermark {
namespace {

using core::Vector3;

/// A method moved through the whole motion.
/// @param effort  for a body that has no least one
/// @param record  takes the number of each frame, 0 included, and the body there
template <class Record>
void move(const std::string &name, const core::Problem &problem, const models::Effort &effort, const Record &record) {
    const auto methods = models::all_moving_methods();
    const auto method = std::ranges::find(methods, name, &models::MovingMethod::name);
    const auto body = method->under_tool(problem);
    const auto &motion = *problem.load_case.tool;
    const auto used = body->least_effort().value_or(effort);
    body->prepare_for(used);
    record(0, *body);
    for (int frame = 1; frame <= motion.num_frames; ++frame) {
        if (frame == core::last_record_held(motion) + 1)
            body->let_go();
        body->advance({.start = motion.time_of(frame - 1)}, used);
        record(frame, *body);
    }
}

core::ToolHistory moved_by(const std::string &name, const core::Problem &problem, const models::Effort &effort) {
    core::ToolHistory history;
    move(name, problem, effort, [&](int frame, const models::FrameBody &body) {
        history.time.push_back(problem.load_case.tool->time_of(frame));
        history.force.push_back(body.tool_force());
        if (core::ToolHistory::has_field(frame))
            for (const auto &u : body.displacement())
                history.displacement.emplace_back(u.cast<float>());
    });
    return history;
}

core::ToolHistory linear_elements(const core::Problem &problem, int steps_per_frame) {
    return hyperelastic::move_tool(problem, hyperelastic::material_law("neo_hookean"), 1, steps_per_frame);
}

core::ToolErrors compare(const core::Problem &problem, const core::ToolHistory &a, const core::ToolHistory &b) {
    return core::compare(problem.body->mesh, *problem.load_case.tool, a, b);
}

TEST(ToolMotionOfElements, ConvergesWithTheSquareOfTheStep) {
    const auto problem = tests::tool_block();
    const auto fine = linear_elements(problem, 64);
    ASSERT_EQ(fine.time.size(), 16U);
    const auto coarse = compare(problem, linear_elements(problem, 4), fine);
    const auto middle = compare(problem, linear_elements(problem, 8), fine);
    EXPECT_LT(middle.contact, 0.3 * coarse.contact);
    EXPECT_LT(middle.contact, 2e-3);
    EXPECT_GT(coarse.contact, 0.0);
}

/// A tool that stays long enough: the body comes to rest in the equilibrium under the pressed and slid place.
TEST(ToolMotionOfElements, ComesToRestInTheStaticSolution) {
    auto problem = tests::tool_block();
    auto &tool = *problem.load_case.tool;
    tool.release_at = 4.0;
    tool.num_frames = 80;
    tool.frame_interval = 0.05;
    const auto moved = linear_elements(problem, 8);
    auto at_rest = problem;
    at_rest.load_case.tool.reset();
    at_rest.load_case.path = {1.0};
    for (std::size_t f = 0; f < at_rest.load_case.value.size(); ++f)
        if (at_rest.load_case.constraint_on(f) == tool.constraint)
            at_rest.load_case.value[f] += tool.slide;
    const auto solution =
        support::find_named(models::all_models(), std::string("fem_p1_neo_hookean"), "model").solve(at_rest);
    const auto num_nodes = problem.body->mesh.points.size();
    const auto *const last = &moved.displacement[moved.displacement.size() - num_nodes];
    for (std::size_t i = 0; i < num_nodes; ++i)
        EXPECT_LT((last[i].cast<double>() - solution.displacement[i]).norm(), 1e-6) << i;
    EXPECT_LT((moved.force.back() + solution.reaction[1]).norm(), 1e-3 * solution.reaction[1].norm());
}

/// All of it slower, with the same frames.
core::Problem slower(core::Problem problem, double factor) {
    auto &tool = *problem.load_case.tool;
    for (double *time :
         {&tool.press_until, &tool.slide_from, &tool.slide_until, &tool.release_at, &tool.frame_interval})
        *time *= factor;
    return problem;
}

/// They have one energy, with as many points for each element. Masses are lumped in place of consistent, which matters
/// the less the slower the tool is.
TEST(MovingMethods, TledAndQuadraticTetrahedraMoveAsElementsOfTheirOrderDo) {
    const auto fast = tests::tool_block(), slow = slower(fast, 6.0);
    for (const auto &[name, degree, rule] :
         {std::tuple("tled", 1, hyperelastic::TetrahedronRule::fourteen_points),
          std::tuple("tled_quadratic", 2, hyperelastic::TetrahedronRule::four_points)}) {
        const auto errors = [&](const core::Problem &problem, int steps_per_frame) {
            return compare(problem, moved_by(name, problem, {}),
                           hyperelastic::move_tool(problem, hyperelastic::material_law("neo_hookean"), degree,
                                                   steps_per_frame, rule));
        };
        const auto fast_errors = errors(fast, 32), slow_errors = errors(slow, 64);
        EXPECT_LT(fast_errors.contact, 0.03) << name;
        EXPECT_LT(slow_errors.contact, 0.2 * fast_errors.contact) << name;
        EXPECT_LT(slow_errors.force, 0.2 * fast_errors.force) << name;
    }
}

/// Methods of one energy, with steps and iterations enough, move alike.
TEST(MovingMethods, MoveAsTheirEnergyDoesOnceStepsAndIterationsAreEnough) {
    const auto problem = tests::tool_block();
    const models::Effort effort{.steps = 64, .iterations = 30};
    const auto descended = moved_by("vertex_block_descent", problem, effort);
    const auto projected = moved_by("xpbd_neo_hookean", problem, effort);
    EXPECT_LT(compare(problem, projected, descended).contact, 2e-3);
    EXPECT_LT(compare(problem, projected, descended).force, 0.02);
    EXPECT_LT(compare(problem, moved_by("corotational_implicit", problem, effort), descended).contact, 0.1);
    EXPECT_LT(compare(problem, moved_by("projective_dynamics", problem, effort), descended).contact, 0.1);
}

/// Softer than linear elements, which lock: near the elements of second order.
TEST(MovingMethods, SpringsAreNearerToTheReferenceThanLinearElements) {
    const auto problem = tests::tool_block();
    const auto reference = models::reference_motion(problem, 0, 8);
    const auto springs = compare(problem, moved_by("nodal_neo_hookean", problem, {}), reference);
    const auto elements = compare(problem, moved_by("tled", problem, {}), reference);
    EXPECT_LT(springs.contact, elements.contact);
    EXPECT_LT(springs.force, elements.force);
}

TEST(MovingMethods, GiveTheSameBitsAgainAndLetGo) {
    const auto problem = tests::tool_block();
    for (const auto &method : models::all_moving_methods()) {
        const models::Effort effort{.steps = 4, .iterations = 4};
        const auto once = moved_by(method.name, problem, effort), again = moved_by(method.name, problem, effort);
        EXPECT_EQ(once.displacement, again.displacement) << method.name;
        EXPECT_GT(once.force[10].norm(), 0.0) << method.name;
        EXPECT_EQ(once.force.back(), core::Vector3::Zero()) << method.name;
        const auto body = method.under_tool(problem);
        EXPECT_GT(body->cost(effort).element_passes, 0.0) << method.name;
        EXPECT_GT(body->cost(effort).bytes_per_element, 0.0) << method.name;
    }
}

/// For the card of each, see the report.
TEST(MovingMethods, SayWhatTheyConvergeToAndWhatTheirUsersWouldObjectTo) {
    for (const auto &method : models::all_moving_methods()) {
        EXPECT_FALSE(method.converges_to.empty()) << method.name;
        EXPECT_TRUE(method.objection.ends_with('.')) << method.name;
    }
}

/// Motion of a method under a ball, frame by frame.
struct TouchedMotion {
    std::vector<Vector3> force;                                ///< (K) of the body on the ball [N]
    std::vector<std::vector<Vector3>> displacement;            ///< (K, N) [m]
    double deepest = -std::numeric_limits<double>::infinity(); ///< inside the ball, as long as it is there [m]
};

constexpr models::Effort small_steps{.steps = 20, .iterations = 2};
/// Effort of methods that solve a linear system in each step.
constexpr models::Effort few_steps{.steps = 2, .iterations = 40};

models::Effort effort_for(const std::string &name) {
    return name == "corotational_implicit" ? few_steps : small_steps;
}

TouchedMotion move_under_ball(const std::string &name, const core::Problem &problem,
                              std::optional<models::Effort> effort = {}) {
    const auto &motion = *problem.load_case.tool;
    const auto &mesh = problem.body->mesh;
    TouchedMotion result;
    const auto points = core::facet_points(core::contact_divisions(*problem.body, problem.load_case));
    move(name, problem, effort.value_or(effort_for(name)), [&](int frame, const models::FrameBody &body) {
        result.force.push_back(body.tool_force());
        result.displacement.push_back(body.displacement());
        if (frame == 0 || frame > core::last_record_held(motion))
            return;
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
    });
    return result;
}

std::vector<std::string> all_methods() {
    std::vector<std::string> names;
    for (const auto &method : models::all_moving_methods()) {
        EXPECT_TRUE(method.knows_contact) << method.name;
        names.push_back(method.name);
    }
    return names;
}

double difference(const std::vector<Vector3> &a, const std::vector<Vector3> &b) {
    const auto expected = msm::to_unknowns(b);
    return (msm::to_unknowns(a) - expected).norm() / expected.norm();
}

/// Ratio of the records of the slide: force along x over that along z.
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
        for (const auto &name : all_methods()) {
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
    for (const auto &name : all_methods()) {
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

/// With points that stick and slip in turn from solution to solution a long step would miss a tenth of the force.
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
    for (const auto &name : all_methods()) {
        const double smooth = slide_ratio(none, move_under_ball(name, none));
        const double rough = slide_ratio(some, move_under_ball(name, some));
        EXPECT_LT(std::abs(smooth), 0.06) << name; // the shape of what it sinks into
        EXPECT_LT(rough, smooth + 0.21) << name;
        EXPECT_GT(rough, smooth + 0.1) << name;
    }
}

/// A ball that stays long enough: springs come to rest under it as in their equilibrium.
TEST(TouchingMethods, SpringsComeToRestInTheirStaticSolution) {
    auto problem = tests::slid_block();
    auto &motion = *problem.load_case.tool;
    motion.slide.setZero();
    motion.release_at = motion.slide_until = 1.0;
    motion.num_frames = 50;
    auto at_rest = problem;
    at_rest.load_case.tool.reset();
    at_rest.load_case.path = {0.5, 1.0};
    for (const std::string name : {"lloyd", "nodal_neo_hookean"}) {
        const auto moved = move_under_ball(name, problem);
        const auto solution = support::find_named(models::all_models(), name, "model").solve(at_rest);
        EXPECT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
        EXPECT_LT((moved.force.back() + solution.reaction.back()).norm(), 1e-4 * moved.force.back().norm());
        EXPECT_LT(difference(moved.displacement.back(), solution.displacement), 1e-4) << name;
    }
}

/// A ball that stays: methods on linear tetrahedra come to about the same force: their energies differ by less than
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
    for (const auto &name : all_methods())
        EXPECT_EQ(move_under_ball(name, problem).force, move_under_ball(name, problem).force) << name;
}

} // namespace
} // namespace livermark
