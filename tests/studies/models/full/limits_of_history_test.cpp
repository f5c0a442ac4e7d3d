#include "studies/models/refined_solution.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <string>

#include "core/error_norms.hpp"
#include "core/mesh/refinement.hpp"
#include "studies/models/model_table.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

/// A rod that is held at one end, and bent by its other end.
core::Problem bent_rod(double poisson) {
    const auto mesh = tests::box_mesh({0.06, 0.03, 0.03}, {2, 1, 1});
    auto load_case = tests::empty_load_case(mesh);
    load_case.regime = core::Regime::large;
    tests::prescribe(load_case, mesh, "x_min", Vector3::Zero());
    tests::press(load_case, mesh, "x_max", {0.0, 0.0, -1.0}, 0.01);
    load_case.slow_history = {.relaxation = {.name = "two", .moduli = {0.3, 0.3}, .times = {0.4, 7.0}},
                              .times = {0.0, 0.5, 1.0, 2.0, 8.0, 30.0},
                              .factors = {0.0, 0.5, 1.0, 1.0, 1.0, 1.0}};
    return {tests::make_body(mesh, {1060.0, 5000.0, poisson}), load_case};
}

core::Solution solve_with(const std::string &name, const core::Problem &problem) {
    const auto models = models::all_models();
    return std::ranges::find(models, name, &core::Model::name)->solve(problem);
}

double force_at(const core::Solution &solution, std::size_t record) {
    return solution.path[record].reaction.back().norm();
}

TEST(LimitsOfAHistory, AreWhereItBeginsAndEnds) {
    const auto problem = bent_rod(0.45);
    auto endless = problem;
    endless.load_case.slow_history->times.back() = 1e9;
    const auto after_all = solve_with("fem_p2p1_neo_hookean", endless);
    const auto relaxed = solve_with("fem_p2p1_neo_hookean", models::relaxed_limit(problem));
    ASSERT_EQ(relaxed.status, core::SolutionStatus::ok) << relaxed.message;
    EXPECT_NEAR(relaxed.reaction.back().norm(), after_all.reaction.back().norm(),
                1e-5 * relaxed.reaction.back().norm());
    EXPECT_LT(relaxed.reaction.back().norm(), 0.6 * force_at(after_all, 2));
}

/// The bar is that of the mesh: a finer one is within it, and not by much more than it has to be.
TEST(LimitsOfAHistory, BoundWhatAFinerMeshMakesOfIt) {
    const auto problem = bent_rod(0.45);
    const auto solution = solve_with("fem_p2p1_neo_hookean_refined", problem);
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
    ASSERT_TRUE(solution.observed_error) << solution.solver;
    const auto &bar = *solution.observed_error;
    const auto finer = core::refine_at_rims(core::refine_at_rims(problem).problem).problem;
    auto expected = solve_with("fem_p2p1_neo_hookean", finer);
    expected.displacement.resize(problem.body->mesh.points.size());
    for (auto &point : expected.path)
        point.displacement.resize(problem.body->mesh.points.size());
    const auto comparison = core::compare(problem.body->mesh, problem.load_case, solution, expected, "on a finer mesh");
    EXPECT_LT(comparison.relative_l2, bar.relative_l2);
    EXPECT_GT(comparison.relative_l2, 0.1 * bar.relative_l2);
    ASSERT_TRUE(bar.stiffness);
    for (std::size_t record = 2; record < expected.path.size(); ++record)
        EXPECT_LT(std::abs(force_at(solution, record) / force_at(expected, record) - 1.0), *bar.stiffness) << record;
}

} // namespace
} // namespace livermark
