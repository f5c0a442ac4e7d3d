#include "results/tables/median_errors.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <memory>

#include "tests/samples/records/sample_result.hpp"

namespace livermark::results {
namespace {

constexpr int springs = 1; // of the models of sample_result()

/// With the springs, and some that are softer under the tool and further off.
Result brief_case(const std::string &load_case, double error, double stiffness, double poisson_ratio = 0.45) {
    auto result = tests::without_motion(tests::sample_result());
    result.models.resize(2);
    result.problem.load_case.name = load_case;
    const auto set = [&](ModelResult &model, double new_error, double new_stiffness) {
        model.comparison->relative_l2 = new_error;
        for (auto &place : model.comparison->tool.value().places) {
            place.stiffness = new_stiffness;
            place.path.clear();
        }
    };
    set(result.models[springs], error, stiffness);
    result.models.push_back(tests::stiffer(result.models[springs]));
    set(result.models.back(), 2.0 * error, 0.5 * stiffness);
    auto body = *result.problem.body;
    body.materials.front().poisson_ratio = poisson_ratio;
    result.problem.body = std::make_shared<const core::Body>(std::move(body));
    return result;
}

TEST(BriefTable, HasTwoNumbersForEachModelAndBody) {
    const std::vector<Result> results{brief_case("a", 0.30, 0.02), brief_case("b", 0.40, -0.04),
                                      brief_case("c", 0.50, 0.12)};
    const auto layout = brief(results);
    const auto body = results.front().problem.body->name;
    ASSERT_EQ(layout.columns.size(), 3U);
    EXPECT_EQ(layout.columns[1].title, body + ": L2 [%]");
    const auto row = std::ranges::find(layout.rows, "springs", [](const auto &cells) { return cells.front(); });
    ASSERT_NE(row, layout.rows.end());
    EXPECT_EQ(*row, (std::vector<std::string>{"springs", "40.00", "4.0"})) << "of both signs";
}

/// The footnote says what a sign means, so that it is there.
TEST(BriefTable, KeepsTheSignThatAllLoadCasesHave) {
    const auto cell = [](std::vector<double> stiffness) {
        std::vector<Result> results;
        for (const double value : stiffness)
            results.push_back(brief_case(std::string(1, static_cast<char>('a' + results.size())), 0.3, value));
        const auto rows = brief(results).rows;
        return std::ranges::find(rows, "springs", [](const auto &cells) { return cells.front(); })->at(2);
    };
    EXPECT_EQ(cell({-0.336}), "-33.6 !");
    EXPECT_EQ(cell({0.336}), "+33.6 !");
    EXPECT_EQ(cell({-0.02, -0.03, -0.12}), "-3.0");
    EXPECT_EQ(cell({-0.02, 0.03, -0.12}), "3.0");
    EXPECT_EQ(cell({0.0}), "0.0");
}

/// A model that is right under the tool alone is not among the best.
TEST(BriefTable, NamesTheBestByTheLargerNumber) {
    const std::vector<Result> results{brief_case("a", 0.30, 0.02), brief_case("b", 0.40, -0.04)};
    const auto legend = brief_legend(results);
    EXPECT_NE(legend.find("by the larger of both numbers, under the tool and in position: springs 3.0 and 35.0 %, "
                          "stiffer 1.5 and 70.0 %\n"),
              std::string::npos)
        << legend;
    const auto best = best_springs(results);
    ASSERT_EQ(best.size(), 1U);
    EXPECT_EQ(best[0].models.front().model, "springs") << "not the one that is nearest under the tool";
}

TEST(BriefTable, NamesTheBestInPositionWhereNothingHasATool) {
    auto result = brief_case("a", 0.30, 0.02);
    for (auto &model : result.models)
        if (model.comparison)
            model.comparison->tool.reset();
    const auto legend = brief_legend(std::vector{result});
    EXPECT_NE(legend.find(", in position: springs 30.0 %, stiffer 60.0 %\n"), std::string::npos) << legend;
}

TEST(BriefTable, HasColumnsForEachPoissonRatio) {
    const std::vector<Result> results{brief_case("a", 0.30, 0.02), brief_case("a", 0.40, 0.08, 0.49)};
    const auto layout = brief(results);
    ASSERT_EQ(layout.columns.size(), 5U);
    EXPECT_NE(layout.columns[1].title, layout.columns[3].title);
    const auto row = std::ranges::find(layout.rows, "springs", [](const auto &cells) { return cells.front(); });
    ASSERT_NE(row, layout.rows.end());
    EXPECT_EQ(*row, (std::vector<std::string>{"springs", "30.00", "+2.0", "40.00", "+8.0 !"}));
}

/// Motion is no case at rest, so it has no place here.
TEST(BriefTable, HasNoRowsWithoutALoadCaseAtRest) {
    const std::vector<Result> results{tests::sample_result()};
    EXPECT_TRUE(brief(results).rows.empty());
}

} // namespace
} // namespace livermark::results
