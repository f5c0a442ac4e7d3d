#include "studies/run/amplitudes.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

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
