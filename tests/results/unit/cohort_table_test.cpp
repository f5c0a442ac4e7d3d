#include "results/tables/cohort_table.hpp"

#include <gtest/gtest.h>

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

} // namespace
} // namespace livermark::results
