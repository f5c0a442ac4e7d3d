#include "results/tables/studies/cohort_table.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "results/quantile.hpp"

namespace livermark::results {
namespace {

TEST(CohortTable, InterpolatesQuantilesBetweenSortedValues) {
    EXPECT_DOUBLE_EQ(quantile({3.0, 1.0, 2.0}, 0.5), 2.0);
    EXPECT_DOUBLE_EQ(quantile({4.0, 1.0, 2.0, 3.0}, 0.5), 2.5);
    EXPECT_DOUBLE_EQ(quantile({0.0, 10.0}, 0.95), 9.5);
    EXPECT_DOUBLE_EQ(quantile({7.0}, 0.95), 7.0);
}

TEST(CohortTable, PutsTheStatisticInsideItsIntervalAndRepeatsIt) {
    std::vector<double> values;
    for (int i = 1; i <= 21; ++i)
        values.push_back(i);
    const auto interval = bootstrap_interval(values, 0.5);
    EXPECT_LT(interval.low, 11.0);
    EXPECT_GT(interval.high, 11.0);
    // The order statistics 6 and 16 hold the median of 21 values with 97 %.
    EXPECT_GE(interval.low, 5.0);
    EXPECT_LE(interval.high, 17.0);
    EXPECT_EQ(bootstrap_interval(values, 0.5).low, interval.low);
    EXPECT_EQ(bootstrap_interval(values, 0.5).high, interval.high);
}

TEST(CohortTable, GivesOneBodyNoWidth) {
    const auto interval = bootstrap_interval({0.25}, 0.5);
    EXPECT_EQ(interval.low, 0.25);
    EXPECT_EQ(interval.high, 0.25);
}

TEST(CohortTable, TakesOddNumbersForTrainingAndEvenOnesForUnseen) {
    EXPECT_EQ(cohort_half("liver_variant_7"), "training");
    EXPECT_EQ(cohort_half("liver_variant_10"), "unseen");
    EXPECT_EQ(cohort_half("liver_healthy"), std::nullopt);
}

CohortError error_of(const std::string &body, const std::string &load_case, double relative_l2) {
    return {.body = body, .load_case = load_case, .model = "springs", .relative_l2 = relative_l2};
}

TEST(CohortStatistics, TakeTheMeanOverLoadCasesThenTheMedianOverTheBodiesOfEachHalf) {
    const std::vector<CohortError> errors{error_of("b_1", "pull", 0.1), error_of("b_1", "push", 0.3),
                                          error_of("b_3", "pull", 0.4), error_of("b_3", "push", 0.6),
                                          error_of("b_2", "pull", 0.7), error_of("b_2", "push", 0.9)};
    const auto statistics = cohort_statistics(errors);
    ASSERT_EQ(statistics.size(), 2U);
    EXPECT_EQ(statistics[0].half, "training");
    EXPECT_DOUBLE_EQ(statistics[0].median, 0.35);
    EXPECT_DOUBLE_EQ(statistics[0].percentile_95, 0.2 + 0.95 * 0.3);
    EXPECT_DOUBLE_EQ(statistics[0].worst, 0.5);
    EXPECT_EQ(statistics[1].half, "unseen");
    EXPECT_DOUBLE_EQ(statistics[1].median, 0.8);
    EXPECT_EQ(statistics[1].left_out, 0);
}

TEST(CohortStatistics, GiveNoIntervalOfFewBodies) {
    std::vector<CohortError> errors;
    for (const auto *const body : {"b_1", "b_3", "b_5", "b_7", "b_9"}) {
        errors.push_back(error_of(body, "pull", 0.01 * static_cast<double>(errors.size() + 1)));
        errors.back().stiffness = -errors.back().relative_l2;
    }
    const auto few = cohort_statistics(errors);
    ASSERT_EQ(few.size(), 1U);
    EXPECT_TRUE(std::isnan(few[0].median_interval.low) && std::isnan(few[0].percentile_95_interval.high));
    EXPECT_EQ(cohort_table(few).rows[0][5], "3.00");
    EXPECT_EQ(cohort_table(few).rows[0][6], "4.80");
    EXPECT_TRUE(std::isnan(few[0].stiffness_median_interval.low));
    EXPECT_EQ(cohort_table(few).rows[0][8], "3.0");
    errors.push_back(error_of("b_11", "pull", 0.06));
    EXPECT_TRUE(std::isnan(cohort_statistics(errors)[0].stiffness_median_interval.low)); // five have a tool
    errors.back().stiffness = 0.06;
    const auto enough = cohort_statistics(errors);
    EXPECT_LT(enough[0].median_interval.low, enough[0].median);
    EXPECT_TRUE(cohort_table(enough).rows[0][5].starts_with("3.50 (")) << cohort_table(enough).rows[0][5];
    EXPECT_TRUE(cohort_table(enough).rows[0][8].starts_with("3.5 (")) << cohort_table(enough).rows[0][8];
}

TEST(CohortStatistics, KeepErrorsAgainstTwoReferencesApart) {
    auto refined = error_of("b_1", "pull", 0.2), on_mesh = error_of("b_1", "pull", 0.1);
    refined.reference = "fem_p2p1_refined";
    on_mesh.reference = "fem_p2p1";
    refined.stiffness = 0.3;
    on_mesh.stiffness = -0.05;
    auto stopped = error_of("b_3", "pull", std::nan("")); // the reference found nothing there
    stopped.status = core::SolutionStatus::diverged;
    const auto statistics = cohort_statistics(std::vector{refined, on_mesh, stopped});
    ASSERT_EQ(statistics.size(), 2U);
    EXPECT_EQ(statistics[0].reference, "fem_p2p1");
    EXPECT_EQ(statistics[0].median, 0.1);
    EXPECT_EQ(statistics[0].stiffness_median, 0.05);
    EXPECT_EQ(statistics[0].left_out, 0);
    EXPECT_EQ(statistics[1].reference, "fem_p2p1_refined");
    EXPECT_EQ(statistics[1].median, 0.2);
    EXPECT_EQ(statistics[1].stiffness_median, 0.3);
    EXPECT_EQ(statistics[1].left_out, 1); // beside the first that there was
}

TEST(CohortStatistics, LeaveOutBodiesWithoutALoadCaseOrAnEnd) {
    auto stopped = error_of("b_5", "push", 0.2);
    stopped.status = core::SolutionStatus::not_converged;
    const std::vector<CohortError> errors{error_of("b_1", "pull", 0.1), error_of("b_1", "push", 0.3),
                                          error_of("b_3", "pull", 0.4), error_of("b_5", "pull", 0.1), stopped};
    const auto statistics = cohort_statistics(errors);
    ASSERT_EQ(statistics.size(), 1U);
    ASSERT_EQ(statistics[0].means.size(), 1U);
    EXPECT_EQ(statistics[0].means[0].body, "b_1");
    EXPECT_EQ(statistics[0].left_out, 2);
    EXPECT_EQ(cohort_table(statistics).rows[0][4], "2");
}

/// Of absolute values: too soft under one load case and too stiff under another is not right in the mean.
TEST(CohortStatistics, TakeTheMeanSizeOfStiffnessAtTheToolOverTheLoadCasesThatHaveOne) {
    std::vector<CohortError> errors{error_of("b_1", "pull", 0.1), error_of("b_1", "push", 0.3),
                                    error_of("b_1", "hang", 0.3), error_of("b_3", "pull", 0.4),
                                    error_of("b_3", "push", 0.6), error_of("b_3", "hang", 0.6)};
    EXPECT_EQ(cohort_table(cohort_statistics(errors)).rows[0][8], "-");
    errors[0].stiffness = -0.1;
    errors[1].stiffness = 0.2;
    errors[3].stiffness = 0.05;
    errors[4].stiffness = 0.05;
    const auto statistics = cohort_statistics(errors);
    EXPECT_DOUBLE_EQ(statistics[0].means[0].stiffness, 0.15);
    EXPECT_DOUBLE_EQ(statistics[0].stiffness_median, 0.1);
    EXPECT_DOUBLE_EQ(statistics[0].stiffness_worst, 0.15);
    const auto row = cohort_table(statistics).rows[0];
    EXPECT_EQ(row[8], "10.0 !");
    EXPECT_EQ(row[9], "15.0 !");
}

TEST(CohortStatistics, KeepRegimesApartAndHaveNoNumberWithoutABody) {
    auto large = error_of("b_1", "large_pull", std::nan(""));
    large.regime = core::Regime::large;
    large.status = core::SolutionStatus::diverged;
    const auto statistics = cohort_statistics(std::vector{large, error_of("b_1", "pull", 0.1)});
    ASSERT_EQ(statistics.size(), 2U);
    EXPECT_EQ(statistics[0].median, 0.1);
    EXPECT_EQ(statistics[1].regime, core::Regime::large);
    EXPECT_EQ(statistics[1].left_out, 1);
    EXPECT_TRUE(std::isnan(statistics[1].median));
}

} // namespace
} // namespace livermark::results
