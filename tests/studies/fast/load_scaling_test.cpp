#include "studies/run/load_scaling.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <stdexcept>
#include <string>

#include "studies/run/benchmark_case.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

constexpr double target_peak = 0.0015; // m

/// A box under a pressure, a body force and a displacement that is not zero.
core::Problem driven_box() {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.08, 0.06}, {4, 3, 3}), {1060.0, 5000.0, 0.45});
    auto load_case = tests::empty_load_case(body->mesh);
    load_case.scale_to_target = true;
    load_case.target_peak_displacement = target_peak;
    load_case.acceleration = {0.0, 0.1, -0.2};
    tests::prescribe(load_case, body->mesh, "x_min", {0.0, 0.0, 0.0});
    tests::prescribe(load_case, body->mesh, "x_max", {0.0004, 0.0, 0.0});
    tests::pull(load_case, body->mesh, "y_max", {0.0, -20.0, 0.0});
    return {body, std::move(load_case)};
}

const core::Model baseline = baseline_of(choose_models({}, {}, false));

double peak_of(const core::Solution &solution) {
    double peak = 0.0;
    for (const auto &displacement : solution.displacement)
        peak = std::max(peak, displacement.norm());
    return peak;
}

TEST(LoadScaling, BringsTheBaselineToTheTarget) {
    PreparedModels prepared;
    const auto problem = driven_box();
    const auto scaled = scaled_to_target(problem, baseline, prepared);
    EXPECT_NEAR(peak_of(baseline.solve(scaled)), target_peak, 5e-6 * target_peak);
    EXPECT_FALSE(scaled.load_case.scale_to_target);
    EXPECT_TRUE(
        core::are_statically_equal(scaled.load_case, core::scaled(problem.load_case, scaled.load_case.load_scale)));
    EXPECT_GT(std::abs(scaled.load_case.load_scale - 1.0), 0.01);
}

/// Machines whose baselines differ in the last digits have the same load.
TEST(LoadScaling, IsTheSameWhateverTheLastDigits) {
    PreparedModels prepared;
    auto problem = driven_box();
    const auto scale = scaled_to_target(problem, baseline, prepared).load_case.load_scale;
    problem.load_case.target_peak_displacement *= 1.0 + 1e-9;
    EXPECT_EQ(scaled_to_target(problem, baseline, prepared).load_case.load_scale, scale);
    EXPECT_EQ(std::stod(fmt::format("{:.5e}", scale)), scale);
}

TEST(LoadScaling, LeavesALoadCaseAloneThatDoesNotAskForIt) {
    PreparedModels prepared;
    auto problem = driven_box();
    problem.load_case.scale_to_target = false;
    EXPECT_EQ(scaled_to_target(problem, baseline, prepared).load_case.load_scale, 1.0);
}

TEST(LoadScaling, NeedsALoadThatMovesTheBaseline) {
    PreparedModels prepared;
    auto problem = driven_box();
    problem.load_case = core::scaled(std::move(problem.load_case), 0.0);
    problem.load_case.scale_to_target = true;
    EXPECT_THROW(scaled_to_target(problem, baseline, prepared), std::runtime_error);
}

} // namespace
} // namespace livermark::studies
