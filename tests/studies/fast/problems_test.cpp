#include "studies/run/problems.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "studies/run/benchmark_case.hpp"
#include "studies/run/solutions.hpp"
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

core::Problem pressed_box() {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {1, 1, 1}), {1e3, 5e3, 0.3});
    auto load_case = tests::empty_load_case(body->mesh);
    load_case.name = "press";
    tests::prescribe(load_case, body->mesh, "x_min", {0.0, 0.0, 0.0});
    tests::pull(load_case, body->mesh, "x_max", {-10.0, 0.0, 0.0});
    return {body, std::move(load_case)};
}

TEST(Amplitudes, MultiplyTheLoadAndStandInTheName) {
    const auto problem = pressed_box();
    const auto found = at_amplitudes(problem, std::vector{0.5, 10.0});
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].load_case.name, "press@0.5");
    EXPECT_EQ(found[1].load_case.name, "press@10");
    EXPECT_TRUE(core::are_statically_equal(found[1].load_case, core::scaled(problem.load_case, 10.0)));
    EXPECT_EQ(found[0].body, problem.body);
}

TEST(Amplitudes, LeaveTheProblemAloneWhereThereAreNone) {
    const auto found = at_amplitudes(pressed_box(), {});
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].load_case.name, "press");
}

/// A result of springs with a nonlinearity at each of two amplitudes.
std::vector<results::Result> results_with(const std::vector<double> &amplitudes,
                                          const std::vector<double> &nonlinearity) {
    std::vector<results::Result> results;
    const auto problems = at_amplitudes(pressed_box(), amplitudes);
    for (std::size_t a = 0; a < problems.size(); ++a) {
        auto &result = results.emplace_back();
        result.problem = problems[a];
        result.models.resize(2);
        result.models[0].name = "springs";
        result.models[0].solution.nonlinearity = nonlinearity[a];
        result.models[1].name = "linear"; // its nonlinearity is not a number
    }
    return results;
}

TEST(Nonlinearity, IsFairUpToTheLastAmplitudeBeforeTheFirstThatIsTooLarge) {
    const std::vector amplitudes{0.1, 1.0, 10.0};
    const auto found = nonlinearity_by_amplitude(results_with(amplitudes, {0.004, 0.04, 0.4}), amplitudes);
    ASSERT_EQ(found.rows.size(), 1u);
    const auto &row = found.rows[0];
    EXPECT_EQ(std::vector(row.begin() + 1, row.end()),
              (std::vector<std::string>{"press", "springs", "0.40", "4.00", "40.00", "x 1"}));
    // One that is fair again later is not fair up to there.
    const auto again = nonlinearity_by_amplitude(results_with(amplitudes, {0.06, 0.04, 0.01}), amplitudes);
    EXPECT_EQ(again.rows.at(0).back(), "none");
}

TEST(Nonlinearity, HasADashWhereAProblemFailedAndTheStatusWhereAModelDid) {
    const std::vector amplitudes{1.0, 2.0, 4.0};
    auto results = results_with(amplitudes, {0.01, 0.01, 0.01});
    results[2].models[0].solution.status = core::SolutionStatus::not_converged;
    results.erase(results.begin() + 1);
    const auto row = nonlinearity_by_amplitude(results, amplitudes).rows.at(0);
    EXPECT_EQ(row.at(4), "-");
    EXPECT_EQ(row.at(5), core::to_string(core::SolutionStatus::not_converged));
}

} // namespace
} // namespace livermark::studies
