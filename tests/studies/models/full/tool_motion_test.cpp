#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include "core/tool/tool_motion.hpp"
#include "fem_reference/hyperelastic/motion.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/motion/moving_method.hpp"
#include "studies/models/motion/whole_motion.hpp"
#include "tests/samples/tool_block.hpp"

namespace livermark {
namespace {

/// A method moved through the whole motion.
core::ToolHistory move(const std::string &name, const core::Problem &problem, const models::Effort &effort) {
    const auto methods = models::all_moving_methods();
    const auto method = std::ranges::find(methods, name, &models::MovingMethod::name);
    const auto body = method->under_tool(problem);
    const auto &motion = *problem.load_case.tool;
    core::ToolHistory history;
    const auto record = [&](int frame) {
        history.time.push_back(motion.time_of(frame));
        history.force.push_back(body->tool_force());
        if (core::ToolHistory::has_field(frame))
            for (const auto &u : body->displacement())
                history.displacement.emplace_back(u.cast<float>());
    };
    record(0);
    for (int frame = 1; frame <= motion.num_frames; ++frame) {
        if (frame == core::last_record_held(motion) + 1)
            body->let_go();
        body->advance({.start = motion.time_of(frame - 1)}, body->least_effort().value_or(effort));
        record(frame);
    }
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
    const auto all = models::all_models();
    const auto model = std::ranges::find(all, "fem_p1_neo_hookean", &core::Model::name);
    ASSERT_NE(model, all.end());
    const auto solution = model->solve(at_rest);
    const auto num_nodes = problem.body->mesh.points.size();
    double difference = 0.0;
    for (std::size_t i = 0; i < num_nodes; ++i)
        difference =
            std::max<double>(difference, (moved.displacement[moved.displacement.size() - num_nodes + i].cast<double>() -
                                          solution.displacement[i])
                                             .norm());
    EXPECT_LT(difference, 1e-6);
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

/// They have one energy. Masses are lumped in place of consistent, which matters the less the slower the tool is.
TEST(MovingMethods, TledMovesAsLinearElementsDo) {
    const auto fast = tests::tool_block(), slow = slower(fast, 6.0);
    const auto fast_errors = compare(fast, move("tled", fast, {}), linear_elements(fast, 32));
    const auto slow_errors = compare(slow, move("tled", slow, {}), linear_elements(slow, 64));
    EXPECT_LT(fast_errors.contact, 0.03);
    EXPECT_LT(slow_errors.contact, 0.2 * fast_errors.contact);
    EXPECT_LT(slow_errors.force, 0.2 * fast_errors.force);
}

/// As above, with the elements of second order that the reference is made of.
TEST(MovingMethods, QuadraticTetrahedraMoveAsQuadraticElementsDo) {
    const auto fast = tests::tool_block(), slow = slower(fast, 6.0);
    const auto elements = [](const core::Problem &problem, int steps_per_frame) {
        return hyperelastic::move_tool(problem, hyperelastic::material_law("neo_hookean"), 2, steps_per_frame,
                                       hyperelastic::TetrahedronRule::four_points);
    };
    const auto fast_errors = compare(fast, move("tled_quadratic", fast, {}), elements(fast, 32));
    const auto slow_errors = compare(slow, move("tled_quadratic", slow, {}), elements(slow, 64));
    EXPECT_LT(fast_errors.contact, 0.03);
    EXPECT_LT(slow_errors.contact, 0.2 * fast_errors.contact);
    EXPECT_LT(slow_errors.force, 0.2 * fast_errors.force);
}

/// Methods of one energy, with steps and iterations enough, move alike.
TEST(MovingMethods, MoveAsTheirEnergyDoesOnceStepsAndIterationsAreEnough) {
    const auto problem = tests::tool_block();
    const models::Effort effort{.steps = 64, .iterations = 30};
    const auto descended = move("vertex_block_descent", problem, effort);
    const auto projected = move("xpbd_neo_hookean", problem, effort);
    EXPECT_LT(compare(problem, projected, descended).contact, 2e-3);
    EXPECT_LT(compare(problem, projected, descended).force, 0.02);
    EXPECT_LT(compare(problem, move("corotational_implicit", problem, effort), descended).contact, 0.1);
    EXPECT_LT(compare(problem, move("projective_dynamics", problem, effort), descended).contact, 0.1);
}

/// Softer than linear elements, which lock: near the elements of second order.
TEST(MovingMethods, SpringsAreNearerToTheReferenceThanLinearElements) {
    const auto problem = tests::tool_block();
    const auto reference = models::reference_motion(problem, 0, 8);
    const auto springs = compare(problem, move("nodal_neo_hookean", problem, {}), reference);
    const auto elements = compare(problem, move("tled", problem, {}), reference);
    EXPECT_LT(springs.contact, elements.contact);
    EXPECT_LT(springs.force, elements.force);
}

TEST(MovingMethods, GiveTheSameBitsAgainAndLetGo) {
    const auto problem = tests::tool_block();
    for (const auto &method : models::all_moving_methods()) {
        const models::Effort effort{.steps = 4, .iterations = 4};
        const auto once = move(method.name, problem, effort), again = move(method.name, problem, effort);
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

} // namespace
} // namespace livermark
