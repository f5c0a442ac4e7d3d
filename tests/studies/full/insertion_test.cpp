#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <utility>

#include "core/support/input_error.hpp"
#include "core/tool/needle/needle.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"
#include "msm/statics/rest_stiffness.hpp"
#include "studies/needle/needle_study.hpp"
#include "tests/samples/random_needles.hpp"
#include "tests/samples/test_meshes.hpp"
#include "tests/studies/insertions.hpp"

namespace livermark::studies {
namespace {

TEST(RandomNeedles, InTheBeamBalanceTheirWork) {
    const auto failed = tests::drive_random_needles("beam", "x_min", 3, 30);
    EXPECT_EQ(failed, std::vector<std::string>{});
}

TEST(RandomNeedles, InLiversBalanceTheirWork) {
    EXPECT_EQ(tests::drive_random_needles("liver_healthy", "posterior", 3, 6), std::vector<std::string>{});
    EXPECT_EQ(tests::drive_random_needles("liver_tumours", "posterior", 3, 6), std::vector<std::string>{});
}

TEST(RandomNeedles, InStepsInTheBeamBalanceTheirWork) {
    EXPECT_EQ(tests::step_random_needles("beam", "x_min", 5, 8), std::vector<std::string>{});
}

TEST(RandomNeedles, InRandomTissueBalanceTheirWork) {
    EXPECT_EQ(tests::drive_into_some_tissue(11, 60, 0.002), std::vector<std::string>{});
}

/// A box of 60 x 30 x 30 mm that is held below, with a needle that goes in from above, aslant.
struct Block {
    core::Problem problem = tests::box_held_below({0.06, 0.03, 0.03}, {8, 4, 4});
    core::Needle needle{.name = "needle",
                        .entry = {0.026, 0.013, 0.03},
                        .target = {0.034, 0.017, 0.011},
                        .diameter = 1e-3,
                        .spread = 8e-3,
                        .toughness = 20.0,
                        .friction = 2.0,
                        .puncture_force = 0.02,
                        .step = 5e-4};

    core::Insertion slowly(const msm::ElasticBody &body) const {
        const auto line = core::needle_line(needle);
        return insert(msm::compliance(body, problem, line.places).matrix, line, needle);
    }
    tests::MovingInsertion in_steps(const msm::ElasticBody &body, const tests::MovingInsertionOptions &options) const {
        return tests::insert_in_steps(body, problem.body->mesh, msm::nodal_conditions(problem, body.node_mass), needle,
                                      options);
    }
};

using tests::patch_springs;

msm::ElasticBody springs_around_nodes(const core::Body &body) {
    return msm::coupled_springs_with_volume(body, msm::find_coupled_springs("nodal_neo_hookean"));
}

/// All the way: forces, tip, surface and target, along the axis and across it. What moves quickly is let alone: the
/// first touch, the turn, and where a place that was held is let go.
TEST(MovingInsertion, MeetsSlowlyWhatTheStaticNeedleDoes) {
    constexpr int start = 5, turn = 3;
    constexpr double rigid = std::numeric_limits<double>::infinity(), bed = 2e4; // N/m^2
    Block block;
    const double spacing = core::needle_line(block.needle).spacing;
    for (const auto &[is_around_nodes, side_stiffness] :
         {std::pair{false, rigid}, std::pair{true, rigid}, std::pair{false, bed}}) {
        SCOPED_TRACE(side_stiffness);
        block.needle.side_stiffness = side_stiffness;
        const auto body =
            is_around_nodes ? springs_around_nodes(*block.problem.body) : patch_springs(*block.problem.body);
        const auto expected = block.slowly(body);
        const auto found = block.in_steps(body, {.speed = 0.01, .time_step = 2e-4, .damping = {40.0, 0.0}}).record;
        ASSERT_GE(found.num_records(), expected.at_plan);
        ASSERT_EQ(found.at_plan, expected.at_plan);
        const double largest = *std::ranges::max_element(expected.force);
        const double farthest = expected.target[expected.at_plan].norm();
        EXPECT_GT(largest, 2.0 * block.needle.tip_force()) << "there is friction";
        int num_compared = 0;
        for (int j = 1; j < std::min(found.num_records(), expected.num_records()); ++j) {
            SCOPED_TRACE(found.depth[j]);
            ASSERT_NEAR(found.depth[j], expected.depth[j], 1e-12);
            EXPECT_NEAR(found.tip[j], expected.tip[j], 0.01 * block.needle.depth());
            EXPECT_NEAR(found.entry[j], expected.entry[j], 0.05 * farthest);
            EXPECT_LT((found.target[j] - expected.target[j]).norm(), 0.06 * farthest);
            const bool turns = j > found.at_plan && j <= found.at_plan + turn;
            if (j < start || turns || std::abs(std::remainder(expected.tip[j], spacing)) < 0.01 * spacing)
                continue;
            // Forces in steps are means from record to record.
            EXPECT_NEAR(found.force[j], 0.5 * (expected.force[j - 1] + expected.force[j]), 0.02 * largest);
            // Beside a bed of springs the target follows more slowly where places are let go on the way out.
            EXPECT_LT((found.target[j] - expected.target[j]).norm(),
                      (side_stiffness == rigid ? 0.02 : 0.06) * farthest);
            ++num_compared;
        }
        EXPECT_GT(num_compared, 0.8 * expected.num_records());
        EXPECT_LT((found.target[found.at_plan] - expected.target[expected.at_plan]).norm(), 0.01 * farthest);
    }
}

/// The surface goes in by a tenth of the block and more: springs in steps are as nonlinear as the needle of the
/// large regime.
TEST(MovingInsertion, MeetsSlowlyWhatTheLargeNeedleDoes) {
    constexpr int start = 5;
    Block block;
    auto &needle = block.needle;
    needle.toughness = 300.0;
    needle.friction = 8.0;
    needle.puncture_force = needle.tip_force();
    const auto line = core::needle_line(needle);
    for (const bool is_around_nodes : {false, true}) {
        const auto springs =
            is_around_nodes ? springs_around_nodes(*block.problem.body) : patch_springs(*block.problem.body);
        const auto body = msm::pushed_springs(springs, block.problem, line.places);
        const auto expected = insert(*body, line, needle);
        ASSERT_TRUE(std::isnan(expected.stopped_at));
        const auto small = block.slowly(springs);
        const auto found = block.in_steps(springs, {.speed = 0.01, .time_step = 1e-4, .damping = {40.0, 0.0}}).record;
        ASSERT_EQ(found.at_plan, expected.at_plan);
        const auto at_plan = static_cast<std::size_t>(found.at_plan);
        const double largest = *std::ranges::max_element(expected.force);
        const double farthest = expected.target[at_plan].norm();
        EXPECT_GT(*std::ranges::max_element(expected.entry), 0.1 * 0.03);
        for (std::size_t j = start; j <= at_plan; ++j) {
            SCOPED_TRACE(found.depth[j]);
            EXPECT_NEAR(found.force[j], 0.5 * (expected.force[j - 1] + expected.force[j]), 0.03 * largest);
            EXPECT_LT((found.target[j] - expected.target[j]).norm(), 0.03 * farthest);
        }
        EXPECT_LT((found.target[at_plan] - expected.target[at_plan]).norm(), 0.02 * farthest);
        EXPECT_GT((small.target[at_plan] - expected.target[at_plan]).norm(), 0.015 * farthest) << "and not linear";
    }
}

TEST(MovingInsertion, BalancesItsWorkSlowlyAndQuickly) {
    const Block block;
    for (const double speed : {0.01, 0.05})
        for (const auto precision : {msm::ForcePrecision::single_precision, msm::ForcePrecision::double_precision}) {
            const auto found =
                block.in_steps(springs_around_nodes(*block.problem.body),
                               {.speed = speed, .time_step = 2e-4, .damping = {20.0, 0.0}, .precision = precision});
            const auto end = static_cast<std::size_t>(found.record.at_plan);
            EXPECT_LT(found.energy_error(), 0.02) << speed;
            EXPECT_GT(found.record.stored[end], 0.01 * found.record.work[end]);
            EXPECT_GT(found.record.friction[end], 0.2 * found.record.work[end]);
            EXPECT_GT(found.record.tearing[end], 0.2 * found.record.work[end]);
            EXPECT_NEAR(found.record.tearing[end], block.needle.tip_force() * found.record.tip[end],
                        0.05 * found.record.tearing[end]);
        }
}

/// The surface holds for longer, so that the needle jumps, and the tissue rings.
TEST(MovingInsertion, BalancesItsWorkWhenItJumps) {
    Block block;
    block.needle.puncture_force = 0.08;
    block.needle.step = 1e-4;
    const auto body = springs_around_nodes(*block.problem.body);
    const auto found = block.in_steps(body, {.speed = 0.01, .time_step = 2e-4, .damping = {20.0, 0.0}});
    const auto expected = block.slowly(body);
    EXPECT_LT(found.energy_error(), 0.02);
    EXPECT_NEAR(found.record.puncture_depth, expected.puncture_depth, 2.0 * block.needle.step);
    EXPECT_NEAR(*std::max_element(found.record.force.begin(), found.record.force.begin() + 20),
                block.needle.puncture_force, 0.3 * block.needle.puncture_force);
}

TEST(MovingInsertion, OfManyNeedlesStaysFiniteAndBalanced) {
    Block block;
    const auto springs = patch_springs(*block.problem.body);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> part;
    for (int n = 0; n < 16; ++n) {
        auto &needle = block.needle;
        needle.entry = {0.015 + 0.03 * part(random), 0.008 + 0.014 * part(random), 0.03};
        needle.target = {0.015 + 0.03 * part(random), 0.008 + 0.014 * part(random), 0.012 + 0.006 * part(random)};
        needle.spread = 0.005 + 0.006 * part(random);
        needle.toughness = 5.0 + 60.0 * part(random);
        needle.friction = n % 4 == 0 ? 0.0 : 6.0 * part(random);
        needle.puncture_force = needle.tip_force() * (n % 2 == 0 ? 1.0 : 1.0 + part(random));
        const auto found = block.in_steps(springs, {.speed = 0.02 + 0.08 * part(random),
                                                    .time_step = 1e-4 + 1e-4 * part(random),
                                                    .damping = {5.0 + 30.0 * part(random), 0.0},
                                                    .precision = n % 3 == 0 ? msm::ForcePrecision::double_precision
                                                                            : msm::ForcePrecision::single_precision});
        for (const double force : found.record.force)
            ASSERT_TRUE(std::isfinite(force)) << n;
        EXPECT_LT(found.energy_error(), 0.02) << n;
    }
}

} // namespace
} // namespace livermark::studies
