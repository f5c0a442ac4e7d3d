#include "results/tables/overview.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <memory>

#include "results/tables/table.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::results {
namespace {

/// Two load cases at 0.3, and one at 0.45.
std::vector<Result> three_results() {
    std::vector<Result> results(3, tests::without_motion(tests::sample_result()));
    results[1].problem.load_case.name = "gravity";
    for (auto &result : results) {
        auto body = *result.problem.body;
        body.materials.front().poisson_ratio = &result == &results[2] ? 0.45 : 0.3;
        result.problem.body = std::make_shared<const core::Body>(std::move(body));
    }
    results[0].models[1].comparison->relative_l2 = 0.10;
    results[1].models[1].comparison->relative_l2 = 0.30;
    results[0].models[1].comparison->reaction_error = 0.50;
    results[1].models[1].comparison->reaction_error = 0.07;
    results[0].models[1].solution.explicit_steps = {0.004, 2e-4, "scalar"};
    results[1].models[1].solution.explicit_steps = {0.003, 1e-4, "scalar"};
    results[2].models[1].comparison->relative_l2 = 0.25;
    results[2].models[1].comparison->reaction_error = 0.25;
    results[2].models[1].solution.explicit_steps = {0.002, 3e-4, "scalar"};
    return results;
}

std::vector<std::string> row_of(const Layout &layout, const std::string &model) {
    const auto found = std::ranges::find(layout.rows, model, [](const auto &row) { return row.at(1); });
    return found == layout.rows.end() ? std::vector<std::string>{} : *found;
}

TEST(Overview, HasTheMeanTheWorstAndTheStepForEachPoissonsRatio) {
    const auto layout = overview(three_results());
    ASSERT_EQ(layout.columns.size(), 17u);
    EXPECT_EQ(layout.columns[2].title, "nu 0.3: mean [%]");
    EXPECT_EQ(layout.columns[9].title, "nu 0.45: mean [%]");
    EXPECT_EQ(layout.rows.size(), 4u);
    // Both load cases have 20 % at the tool; the first by name is shown.
    EXPECT_EQ(row_of(layout, "springs"),
              (std::vector<std::string>{"box", "springs", "20.00", "30.00", "20.0 !", "+20.0 ! gravity", "28.50",
                                        "50.00", "3", "25.00", "25.00", "20.0 !", "+20.0 ! pull_and_hang", "25.00",
                                        "25.00", "2", "100"}));
}

TEST(Overview, MeansHaveAColumnForEachBody) {
    const auto layout = mean_errors(three_results());
    ASSERT_EQ(layout.columns.size(), 5u);
    EXPECT_EQ(layout.columns[1].title, "box, nu 0.3 [%]");
    EXPECT_EQ(layout.columns[2].title, "box, nu 0.3: tool [%]");
    EXPECT_EQ(layout.columns[3].title, "box, nu 0.45 [%]");
    EXPECT_EQ(layout.rows.at(1), (std::vector<std::string>{"springs", "20.00", "20.0 !", "25.00", "20.0 !"}));
}

TEST(Overview, GivesTheReferenceItsUncertaintyAndAFailureItsStatus) {
    const auto layout = overview(three_results());
    EXPECT_EQ(row_of(layout, "fem_p2")[2], "+- 19.00");
    EXPECT_EQ(row_of(layout, "blown_up")[2], "-");
    EXPECT_EQ(row_of(layout, "blown_up")[3], "diverged");
}

TEST(Overview, NamesPoissonsRatioOnlyWhereThereAreSeveral) {
    const auto results = three_results();
    EXPECT_TRUE(has_several_poisson_ratios(results));
    EXPECT_EQ(body_label(results[2], results), "box, nu 0.45");
    const std::span one(results.data(), 2);
    EXPECT_FALSE(has_several_poisson_ratios(one));
    EXPECT_EQ(body_label(results[0], one), "box");
}

/// A release starts as the pull before it does: its error would count twice.
TEST(Overview, CountsNoStaticStartOfAMotionAndNoMultipleOfALoad) {
    auto results = three_results();
    results.push_back(tests::sample_result());
    results.push_back(results[0]);
    results.back().problem.load_case.name += "@10";
    for (const auto r : {3, 4}) {
        auto body = *results[r].problem.body;
        body.materials.front().poisson_ratio = 0.3;
        results[r].problem.body = std::make_shared<const core::Body>(std::move(body));
        results[r].models[1].comparison->relative_l2 = 0.9;
        results[r].models[1].comparison->reaction_error = 0.9;
        for (auto &place : results[r].models[1].comparison->tool.value().places) {
            place.stiffness = 0.9;
            place.path.clear();
        }
    }
    EXPECT_EQ(overview(results).rows, overview(three_results()).rows);
    EXPECT_EQ(mean_errors(results).rows, mean_errors(three_results()).rows);
    const auto layout = summary(results);
    EXPECT_EQ(row_of(layout, "springs")[2], "90.00"); // of the motion, whose load case has the same name
    EXPECT_EQ(row_of(layout, "springs")[5], "20.00"); // the mean
    EXPECT_EQ(row_of(layout, "springs")[7], row_of(summary(three_results()), "springs")[6]); // and at the tool
}

TEST(Overview, SaysOverHowManyLoadCasesAMeanIsThatIsNotOverAll) {
    auto results = three_results();
    auto guest = results[0].models[1];
    guest.name = "guest";
    results[0].models.push_back(guest);
    EXPECT_EQ(row_of(overview(results), "guest")[2], "10.00 (1 of 2)");
    EXPECT_EQ(row_of(overview(results), "guest")[9], "-");
    EXPECT_EQ(mean_errors(results).rows.back(),
              (std::vector<std::string>{"guest", "10.00 (1 of 2)", "20.0 !", "-", "-"}));
    EXPECT_EQ(row_of(summary(results), "guest")[4], "10.00 (1 of 2)");
}

TEST(Overview, TakesAModelFromTheFileThatHasIt) {
    auto all = three_results();
    all.resize(2); // at one ratio
    auto apart = all;
    for (const auto r : {0, 1}) { // the springs in files of their own
        apart.push_back(all[r]);
        apart[r].models.erase(apart[r].models.begin() + 1);
        apart.back().models.resize(2);
    }
    EXPECT_EQ(row_of(overview(apart), "springs"), row_of(overview(all), "springs"));
    EXPECT_EQ(row_of(summary(apart), "springs")[4], row_of(summary(all), "springs")[4]);
}

TEST(Overview, CallsNoModelTheReferenceWhereNothingWasCompared) {
    auto results = three_results();
    results.resize(1);
    for (auto &model : results[0].models)
        model.comparison.reset();
    EXPECT_EQ(row_of(summary(results), "fem_p2")[2], "not compared");
    EXPECT_EQ(row_of(summary(three_results()), "fem_p2")[2], "reference");
}

} // namespace
} // namespace livermark::results
