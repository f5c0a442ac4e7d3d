#include "load_cases/experiments/markers.hpp"

#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>

#include "load_cases/experiments/experiment.hpp"
#include "studies/needle/needle_study.hpp"

namespace livermark::experiments {
namespace {

struct MeasuredNeedles : testing::Test {
    void SetUp() override {
        if (!has_needle_curve())
            GTEST_SKIP() << "the measured needle is not in " << data_folder() << "; 'livermark needle --measured' says "
                         << "where to get it";
    }
};

TEST_F(MeasuredNeedles, ArePuncturedWhereThePublishedOneIs) {
    const auto curve = read_needle_curve();
    EXPECT_EQ(curve.depth.size(), 371U);
    const auto puncture = puncture_of(curve, 0.002);
    EXPECT_NEAR(puncture.depth, 0.0191, 1e-4);
    EXPECT_NEAR(puncture.force, 1.41, 0.01);
    const auto bins = binned(curve, 0.002);
    for (std::size_t b = 0; b < bins.size(); ++b) {
        EXPECT_LE(bins[b].lowest, bins[b].mean);
        EXPECT_GE(bins[b].highest, bins[b].mean);
        EXPECT_GE(bins[b].from, b > 0 ? bins[b - 1].to - 1e-12 : 0.0);
    }
}

/// Fitted to the depth and the force of the puncture, and to the work behind it. What is not fitted is the force right
/// behind the puncture, which is that of tearing.
TEST_F(MeasuredNeedles, AreMetWhereTheyAreFittedAndBehindThePuncture) {
    studies::NeedleOptions options;
    options.bodies = {"liver_healthy"};
    options.load_case = "puncture";
    options.models = {"fem_p1"};
    options.reference_on_mesh = true;
    const auto measured = studies::compare_with_measured(options, {});
    ASSERT_EQ(measured.runs.size(), 2U);
    for (const auto &run : measured.runs) {
        EXPECT_NEAR(run.insertion.puncture_depth, measured.puncture_depth, 2.0 * measured.needle.step) << run.model;
        EXPECT_GT(run.friction, 0.0);
        EXPECT_GT(run.stiffness, 0.0);
        EXPECT_LT(run.error, 0.5 * *std::ranges::max_element(measured.mean));
        const auto behind =
            std::ranges::find_if(measured.from, [&](double from) { return from > measured.puncture_depth; }) -
            measured.from.begin();
        EXPECT_GT(run.force[behind], measured.needle.tip_force());
        EXPECT_LT(run.force[behind], 2.5 * measured.highest[behind]);
    }
    EXPECT_GT(measured.runs[1].stiffness / measured.runs[0].stiffness, 0.1);
    EXPECT_LT(measured.runs[1].stiffness, measured.runs[0].stiffness) << "linear tetrahedra are too stiff already";
}

} // namespace
} // namespace livermark::experiments
