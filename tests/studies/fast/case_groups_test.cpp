#include "studies/run/work/case_groups.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>

#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::shared_ptr<const core::Body> bar_of(int bricks) {
    return tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {bricks, 1, 1}), {1e3, 5e3, 0.3});
}

/// Constrained at some patches in all components, or in one alone, and pulled at x_max.
core::Problem problem(const std::shared_ptr<const core::Body> &body, const std::vector<std::string> &fixed,
                      double traction, const std::vector<std::string> &sliding = {}) {
    auto load_case = tests::empty_load_case(body->mesh);
    for (const auto &patch : fixed)
        tests::prescribe(load_case, body->mesh, patch, {0.0, 0.0, 0.0});
    for (const auto &patch : sliding)
        tests::prescribe(load_case, body->mesh, patch, {nan, nan, 0.0});
    tests::pull(load_case, body->mesh, "x_max", {traction, 0.0, 0.0});
    return {body, std::move(load_case)};
}

TEST(CaseGroups, HaveOneStaticSolutionEach) {
    const auto body = bar_of(1);
    auto moving = problem(body, {"x_min"}, 10.0);
    moving.load_case.release = core::Release{.num_steps = 1, .output_interval = 0.1, .damping = {}, .probes = {}};
    const std::vector problems{problem(body, {"x_min"}, 10.0), problem(body, {"x_min"}, 20.0), moving};
    const auto found = case_groups_of(problems);
    EXPECT_EQ(found.problems, (std::vector<CaseGroup>{{0, 2}, {1}}));
    EXPECT_EQ(found.body, (std::vector{0, 0}));
}

TEST(CaseGroups, OfDifferentBodiesAreDifferentEvenWhereTheLoadIsTheSame) {
    const auto one = bar_of(1), twin = bar_of(1);
    const std::vector problems{problem(one, {"x_min"}, 10.0), problem(twin, {"x_min"}, 10.0)};
    EXPECT_EQ(case_groups_of(problems).body, (std::vector{0, 1}));
}

TEST(CaseGroups, ThatConstrainTheSameFollowEachOther) {
    const auto body = bar_of(1);
    const std::vector problems{problem(body, {"x_min"}, 1.0), problem(body, {"y_min"}, 1.0),
                               problem(body, {"x_min"}, 2.0), problem(body, {"y_min"}, 2.0)};
    EXPECT_EQ(case_groups_of(problems).problems, (std::vector<CaseGroup>{{0}, {2}, {1}, {3}}));
}

TEST(CaseGroups, OfTheLargestBodyComeFirst) {
    const auto small = bar_of(1), large = bar_of(3);
    const std::vector problems{problem(small, {"x_min"}, 1.0), problem(large, {"x_min"}, 1.0)};
    const auto found = case_groups_of(problems);
    EXPECT_EQ(found.problems, (std::vector<CaseGroup>{{1}, {0}}));
    EXPECT_EQ(found.body, (std::vector{0, 1})) << "numbered in the order in which they come";
}

TEST(MostShared, IsWhatMostLoadCasesConstrain) {
    const auto body = bar_of(2);
    const std::vector problems{problem(body, {"x_min"}, 1.0), problem(body, {"x_min"}, 1.0, {"z_min"}),
                               problem(body, {"x_min", "y_min"}, 1.0), problem(body, {"z_max"}, 1.0)};
    const auto found = most_shared(problems);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_TRUE(core::constrain_the_same(found[0].load_case, problems[0].load_case));
}

TEST(MostShared, IsNothingWhereNoLoadCaseConstrainsMoreThanAnother) {
    const auto body = bar_of(2);
    EXPECT_TRUE(most_shared(std::vector{problem(body, {"x_min"}, 1.0), problem(body, {"x_min"}, 2.0),
                                        problem(body, {"y_min"}, 1.0)})
                    .empty());
}

TEST(MostShared, IsFoundForEachBody) {
    const auto one = bar_of(1), other = bar_of(2);
    const std::vector problems{problem(one, {"x_min"}, 1.0), problem(one, {"x_min", "y_min"}, 1.0),
                               problem(other, {"y_min"}, 1.0), problem(other, {"x_min", "y_min"}, 1.0)};
    const auto found = most_shared(problems);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].body, one);
    EXPECT_TRUE(core::constrain_the_same(found[1].load_case, problems[2].load_case));
}

} // namespace
} // namespace livermark::studies
