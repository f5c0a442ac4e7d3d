#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <string>

#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "core/tool/needle/needle.hpp"
#include "studies/arena/arena.hpp"
#include "studies/arena/arena_run.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/motion/moving_method.hpp"
#include "studies/needle/needle_study.hpp"
#include "tests/studies/insertions.hpp"

namespace livermark::studies {
namespace {

/// Time of the processor [s].
void spend(double seconds) {
    const double end = core::processor_seconds() + seconds;
    while (core::processor_seconds() < end)
        ;
}

/// The largest effort of whole steps of one iteration whose frame takes so much time for a number of them [s].
std::optional<MeasuredEffort> largest_steps(const std::function<double(int)> &seconds, double budget) {
    return largest_effort([&](const models::Effort &effort) { spend(seconds(effort.steps)); },
                          models::Setting::one_iteration, budget);
}

TEST(LargestEffort, FillsTheBudgetWhereTimeIsALine) {
    const auto fits = largest_steps([](int steps) { return 1e-4 + 2e-4 * steps; }, 4e-3);
    ASSERT_TRUE(fits);
    EXPECT_NEAR(fits->effort.steps, 19, 3);
}

/// As under a ball, where one step of a whole frame is solved five times, and short ones once.
TEST(LargestEffort, FitsWhereOneStepTakesAsLongAsMany) {
    const auto fits = largest_steps([](int steps) { return steps < 4 ? 2e-3 / steps : 2e-4 * steps; }, 4e-3);
    ASSERT_TRUE(fits);
    EXPECT_NEAR(fits->effort.steps, 20, 3); // a line through the first two would say 20,000
    EXPECT_NEAR(fits->seconds, 4e-3, 4e-4);
}

/// As conjugate gradients that have converged: more iterations are a limit, and take no more time.
TEST(LargestEffort, SaysWhereAMethodStopsEarlier) {
    const auto frame = [](const models::Effort &effort) { spend(5e-5 * std::min(effort.iterations, 20)); };
    const auto stops = largest_effort(frame, models::Setting::one_step, 4e-3);
    ASSERT_TRUE(stops);
    EXPECT_TRUE(stops->stops_early);
    EXPECT_GT(stops->effort.iterations, 100);
    EXPECT_LT(stops->seconds, 2e-3);
    const auto fills = largest_effort(frame, models::Setting::one_step, 5e-4);
    ASSERT_TRUE(fills);
    EXPECT_FALSE(fills->stops_early);
}

TEST(LargestEffort, IsTheLeastWhereNothingFits) {
    const auto fits = largest_steps([](int steps) { return 2e-3 * steps; }, 1e-3);
    ASSERT_TRUE(fits);
    EXPECT_EQ(fits->effort.steps, 1);
}

/// A box of 40 x 30 x 30 mm that is held below, with a needle that goes in from above, aslant, and hardly moves it.
struct NeedledBlock {
    core::Problem problem = tests::box_held_below({0.04, 0.03, 0.03}, {4, 3, 3});
    core::Needle needle{.name = "needle",
                        .entry = {0.016, 0.013, 0.03},
                        .target = {0.024, 0.017, 0.014},
                        .diameter = 1e-3,
                        .spread = 8e-3,
                        .toughness = 8.0,
                        .friction = 1.0,
                        .puncture_force = 8e-3,
                        .step = 2e-4};
    models::NeedlePlan plan{.speed = 0.02, .rest = 0.1, .mass_damping = 30.0};
    core::Insertion statically = [this] {
        const auto fem = support::find_named(models::all_models(), "fem_p1", "model");
        const auto line = core::needle_line(needle);
        return insert(fem.compliance(problem, line.places).matrix, line, needle);
    }();
};

models::MovingMethod method_named(const std::string &name) {
    return support::find_named(models::all_moving_methods(), name, "method");
}

TEST(NeedlePlan, LeadsInRestsAndLeadsOut) {
    const core::Needle needle{.name = "down", .entry = {0.0, 0.0, 0.0}, .target = {0.0, 0.0, 0.03}};
    const models::NeedlePlan plan{.speed = 0.06, .rest = 0.1};
    EXPECT_EQ(plan.at_plan(needle), 30);
    EXPECT_EQ(plan.num_frames(needle), 66);
    EXPECT_EQ(plan.depth_after(needle, 0), 0.0);
    EXPECT_NEAR(plan.depth_after(needle, 1), 1e-3, 1e-15);
    for (const int frame : {30, 33, 36})
        EXPECT_NEAR(plan.depth_after(needle, frame), 0.03, 1e-15);
    EXPECT_NEAR(plan.depth_after(needle, 46), 0.02, 1e-15);
    EXPECT_EQ(plan.depth_after(needle, 66), 0.0);
}

/// All these have the stiffness of linear elements at rest, and so, slowly, the needle of their compliance.
TEST(NeedledBodies, OfTheEnergyOfLinearElementsMeetTheNeedleOfThese) {
    const NeedledBlock block;
    const auto &expected = block.statically;
    const auto at_plan = static_cast<std::size_t>(expected.at_plan);
    const double farthest = expected.target[at_plan].norm();
    EXPECT_GT(farthest, 5e-5);
    struct Converged {
        std::string name;
        models::Effort effort;
    };
    for (const auto &[name, effort] : {Converged{"tled", {}}, Converged{"corotational_implicit", {1, 60}},
                                       Converged{"vertex_block_descent", {1, 200}}}) {
        SCOPED_TRACE(name);
        const auto body = method_named(name).with_needle(block.problem, block.needle, block.plan);
        const auto used = body->least_effort().value_or(effort);
        body->prepare_for(used);
        double peak = 0.0;
        for (int frame = 1; frame <= block.plan.at_plan(block.needle); ++frame) {
            body->advance({.depth = block.plan.depth_after(block.needle, frame)}, used);
            peak = std::max(peak, body->reading().force);
        }
        const auto reading = body->reading();
        ASSERT_EQ(reading.places.size(), expected.places.size());
        const auto target = static_cast<std::size_t>(core::needle_line(block.needle).target);
        EXPECT_LT((reading.places[target] - expected.target[at_plan]).norm(), 0.05 * farthest);
        EXPECT_NEAR(reading.tip, expected.tip[at_plan], 0.01 * block.needle.depth());
        EXPECT_NEAR(peak, *std::ranges::max_element(expected.force), 0.05 * peak);
    }
}

/// Then it is let alone, and nothing goes on by itself.
TEST(NeedledBodies, HoldStillWhileTheNeedleRests) {
    NeedledBlock block;
    block.plan.rest = 1.0;
    for (const std::string name : {"lloyd", "tled_nodal_pressure", "corotational_implicit", "vertex_block_descent"}) {
        SCOPED_TRACE(name);
        const auto body = method_named(name).with_needle(block.problem, block.needle, block.plan);
        const auto effort = body->least_effort().value_or(models::Effort{1, 30});
        const int in = block.plan.at_plan(block.needle);
        for (int frame = 1; frame <= in + 50; ++frame)
            body->advance({.depth = block.plan.depth_after(block.needle, frame)}, effort);
        const auto before = body->reading();
        for (int frame = in + 51; frame <= in + 60; ++frame)
            body->advance({.depth = block.plan.depth_after(block.needle, frame)}, effort);
        const auto after = body->reading();
        EXPECT_GT(before.force, 5e-3);
        EXPECT_NEAR(after.force, before.force, 0.02 * before.force);
        EXPECT_LT((after.places.back() - before.places.back()).norm(), 0.02 * before.places.back().norm());
    }
}

TEST(NeedledBodies, GoOnAloneFromTheMotionOfAnother) {
    const NeedledBlock block;
    for (const std::string name : {"lloyd", "tled", "corotational_implicit"}) {
        SCOPED_TRACE(name);
        const auto method = method_named(name);
        const auto body = method.with_needle(block.problem, block.needle, block.plan);
        const auto other = method.with_needle(block.problem, block.needle, block.plan);
        const auto effort = body->least_effort().value_or(models::Effort{1, 20});
        for (int frame = 1; frame <= 20; ++frame)
            body->advance({.depth = block.plan.depth_after(block.needle, frame)}, effort);
        other->take_motion_of(*body);
        EXPECT_LT((other->displacement()[40] - body->displacement()[40]).norm(), 1e-8);
        other->advance_alone(effort);
        EXPECT_GT((other->displacement()[40] - body->displacement()[40]).norm(), 0.0);
        EXPECT_EQ(other->reading().tip, 0.0);
    }
}

/// Between records the reference is linear, and a rest changes nothing.
TEST(NeedleArena, HasTheStaticNeedleAtTheDepthsOfThePlan) {
    const core::Needle needle{.name = "down", .entry = {0.0, 0.0, 0.0}, .target = {0.0, 0.0, 0.03}};
    const models::NeedlePlan plan{.speed = 0.06, .rest = 0.1};
    core::Insertion insertion;
    for (const double depth : {0.0, 0.015, 0.03, 0.015, 0.005}) {
        const bool is_out = insertion.num_records() > 2;
        insertion.depth.push_back(depth);
        insertion.force.push_back(is_out ? -10.0 * depth : 30.0 * depth);
        insertion.target.emplace_back(0.0, 0.0, 0.1 * depth);
    }
    insertion.at_plan = 2;
    auto coarser = insertion;
    for (double &force : coarser.force)
        force *= 1.01;
    const auto arena = empty_needle_arena(needle, plan, insertion, &coarser);
    ASSERT_EQ(arena.depth.size(), 67U);
    EXPECT_EQ(arena.at_plan, 30);
    EXPECT_NEAR(arena.reference_force[7], 30.0 * 0.007, 1e-12);
    for (const int frame : {30, 33, 36})
        EXPECT_NEAR(arena.reference_force[frame], 0.9, 1e-12);
    EXPECT_NEAR(arena.reference_force[51], -0.15, 1e-12);
    EXPECT_NEAR(arena.reference_force[56], -0.10, 1e-12);
    EXPECT_NEAR(arena.reference_force[66], -0.05, 1e-12) << "its end";
    EXPECT_NEAR(arena.reference_target[7].z(), 0.0007, 1e-12);
    EXPECT_NEAR(arena.reference_forces.peak, 0.9, 1e-12);
    EXPECT_NEAR(arena.reference_forces.slope, 30.0, 1e-9);
    EXPECT_NEAR(arena.reference_forces.pull, 0.15, 1e-12);
    EXPECT_NEAR(arena.reference_changes.peak, 0.009, 1e-12);
    EXPECT_TRUE(std::isnan(empty_needle_arena(needle, plan, insertion, nullptr).reference_changes.peak));
}

} // namespace
} // namespace livermark::studies
