#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>

#include "core/tool/tool_motion.hpp"
#include "tests/samples/tool_block.hpp"

namespace livermark {
namespace {

TEST(ToolMotion, BeginsAndEndsItsWaysAtRestAndWithoutAJerk) {
    constexpr double h = 1e-4;
    EXPECT_EQ(core::smooth_step(-1.0, 0.0, 2.0), 0.0);
    EXPECT_EQ(core::smooth_step(3.0, 0.0, 2.0), 1.0);
    EXPECT_DOUBLE_EQ(core::smooth_step(1.0, 0.0, 2.0), 0.5);
    for (const double end : {0.0, 2.0}) {
        const double here = core::smooth_step(end, 0.0, 2.0);
        EXPECT_NEAR(core::smooth_step(end + h, 0.0, 2.0), here, 2e-12); // velocity and acceleration vanish
        EXPECT_NEAR(core::smooth_step(end - h, 0.0, 2.0), here, 2e-12);
    }
}

TEST(ToolMotion, LetsGoOfItsPlaceAlone) {
    const auto problem = tests::tool_block();
    const auto free = core::let_go(problem.load_case);
    int num_free = 0;
    for (int f = 0; f < free.num_facets(); ++f) {
        const bool is_tool = problem.load_case.constraint_on(f) == 1;
        EXPECT_EQ(free.condition_on[f], is_tool ? -1 : problem.load_case.condition_on[f]);
        num_free += is_tool ? 1 : 0;
    }
    EXPECT_EQ(num_free, 8);
    EXPECT_EQ(core::last_record_held(*free.tool), 11); // at 0.22 s, in frames of 0.02 s
}

TEST(ToolMotion, SlidesWithAllOfItsPlace) {
    auto problem = tests::tool_block();
    problem.load_case.node_factor.assign(problem.body->mesh.points.size(), 0.5);
    const auto slid = core::with_slide(problem.load_case);
    EXPECT_TRUE(slid.node_factor.empty());
    int num_slid = 0;
    for (int f = 0; f < slid.num_facets(); ++f)
        if (slid.constraint_on(f) == 1) {
            ++num_slid;
            EXPECT_EQ(slid.value[f], problem.load_case.tool->slide);
        }
    EXPECT_EQ(num_slid, 8); // two for each of 2 x 2 bricks
}

/// Two nodes' worth of motion: everything is k times the reference.
core::ToolHistory history_of(const core::Problem &problem, double factor) {
    core::ToolHistory history;
    for (int k = 0; k <= problem.load_case.tool->num_frames; ++k) {
        history.time.push_back(k * problem.load_case.tool->frame_interval);
        history.force.emplace_back(factor * k, 0.0, 0.0);
        if (core::ToolHistory::has_field(k))
            for (std::size_t i = 0; i < problem.body->mesh.points.size(); ++i)
                history.displacement.emplace_back(0.0F, static_cast<float>(factor * k), 0.0F);
    }
    return history;
}

TEST(ToolErrors, AreRelativeToTheReferenceInEachPartOfTheMotion) {
    const auto problem = tests::tool_block();
    const auto reference = history_of(problem, 1.0);
    auto other = history_of(problem, 1.25);
    const auto errors = core::compare(problem.body->mesh, *problem.load_case.tool, other, reference);
    EXPECT_NEAR(errors.contact, 0.25, 1e-6);
    EXPECT_NEAR(errors.after, 0.25, 1e-6);
    EXPECT_NEAR(errors.force, 0.25, 1e-12);
    ASSERT_EQ(errors.over_time.size(), 4U);
    EXPECT_NEAR(errors.over_time.back(), 0.25, 1e-6);
    EXPECT_EQ(errors.over_time.front(), 0.0);
    other.displacement.back().x() = NAN;
    EXPECT_TRUE(std::isnan(core::compare(problem.body->mesh, *problem.load_case.tool, other, reference).after));
    other.force.pop_back();
    EXPECT_THROW(core::compare(problem.body->mesh, *problem.load_case.tool, other, reference), std::invalid_argument);
}

} // namespace
} // namespace livermark
