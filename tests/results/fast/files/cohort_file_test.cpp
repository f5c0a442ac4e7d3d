#include "results/records/cohort.hpp"

#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>

#include "core/support/input_error.hpp"
#include "results/hdf5/hdf5_io.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/quantile.hpp"
#include "results/records/result.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/records/sample_cohort.hpp"

namespace livermark::results {
namespace {

using CohortFile = tests::ResultFolder;

TEST_F(CohortFile, HoldsWhatWasWritten) {
    auto written = tests::sample_cohort();
    written.provenance = current_provenance("livermark cohort --bodies 1-3");
    write_cohort(path_, written);
    EXPECT_EQ(kind_of_file(path_), FileKind::cohort);
    const auto read = read_cohort(path_);
    EXPECT_EQ(read.provenance, written.provenance);
    EXPECT_EQ(read.tetrahedra, written.tetrahedra);
    EXPECT_EQ(read.failures, written.failures);
    ASSERT_EQ(read.bodies.size(), written.bodies.size());
    for (std::size_t b = 0; b < read.bodies.size(); ++b) {
        EXPECT_EQ(read.bodies[b].number, written.bodies[b].number);
        EXPECT_EQ(read.bodies[b].name, written.bodies[b].name);
        EXPECT_EQ(read.bodies[b].volume, written.bodies[b].volume);
        EXPECT_EQ(read.bodies[b].has_riedel_lobe, written.bodies[b].has_riedel_lobe);
        ASSERT_EQ(read.bodies[b].lesions.size(), written.bodies[b].lesions.size());
        for (std::size_t l = 0; l < read.bodies[b].lesions.size(); ++l)
            EXPECT_EQ(read.bodies[b].lesions[l].semi_axes, written.bodies[b].lesions[l].semi_axes);
    }
    ASSERT_EQ(read.errors.size(), written.errors.size());
    for (std::size_t e = 0; e < read.errors.size(); ++e) {
        EXPECT_EQ(read.errors[e].body, written.errors[e].body);
        EXPECT_EQ(read.errors[e].load_case, written.errors[e].load_case);
        EXPECT_EQ(read.errors[e].model, written.errors[e].model);
        EXPECT_EQ(read.errors[e].regime, written.errors[e].regime);
        EXPECT_EQ(read.errors[e].status, written.errors[e].status);
        EXPECT_EQ(read.errors[e].reference, written.errors[e].reference);
        EXPECT_TRUE(read.errors[e].relative_l2 == written.errors[e].relative_l2 ||
                    (std::isnan(read.errors[e].relative_l2) && std::isnan(written.errors[e].relative_l2)));
        EXPECT_TRUE(read.errors[e].stiffness == written.errors[e].stiffness ||
                    (std::isnan(read.errors[e].stiffness) && std::isnan(written.errors[e].stiffness)));
        EXPECT_TRUE(
            read.errors[e].tool_radius_in_edges == written.errors[e].tool_radius_in_edges ||
            (std::isnan(read.errors[e].tool_radius_in_edges) && std::isnan(written.errors[e].tool_radius_in_edges)));
    }
}

TEST(CohortHalf, IsTrainingOfOddNumbersAndUnseenOfEvenOnes) {
    EXPECT_EQ(cohort_half("liver_variant_7"), "training");
    EXPECT_EQ(cohort_half("liver_variant_10"), "unseen");
    EXPECT_EQ(cohort_half("liver_healthy"), std::nullopt);
}

TEST(Quantile, IsInterpolatedBetweenSortedValues) {
    EXPECT_DOUBLE_EQ(quantile({3.0, 1.0, 2.0}, 0.5), 2.0);
    EXPECT_DOUBLE_EQ(quantile({4.0, 1.0, 2.0, 3.0}, 0.5), 2.5);
    EXPECT_DOUBLE_EQ(quantile({0.0, 10.0}, 0.95), 9.5);
    EXPECT_DOUBLE_EQ(quantile({7.0}, 0.95), 7.0);
}

TEST_F(CohortFile, HoldsACohortWithoutAnyResult) {
    auto written = tests::sample_cohort();
    written.errors.clear();
    for (auto &body : written.bodies)
        body.lesions.clear();
    write_cohort(path_, written);
    const auto read = read_cohort(path_);
    EXPECT_TRUE(read.errors.empty());
    EXPECT_EQ(read.bodies.size(), 3U);
    EXPECT_EQ(read.failures.size(), 2U);
}

TEST_F(CohortFile, IsRefusedWhereItIsCutOff) {
    write_cohort(path_, tests::sample_cohort());
    std::filesystem::resize_file(path_, std::filesystem::file_size(path_) / 2);
    EXPECT_THROW(read_cohort(path_), support::InputError);
}

} // namespace
} // namespace livermark::results
