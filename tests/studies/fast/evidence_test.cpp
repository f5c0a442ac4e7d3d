#include "studies/advise/advise.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "tests/bad_input.hpp"

namespace livermark::studies {
namespace {

constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

results::CohortError error_of(const std::string &body, const std::string &model, double stiffness, double l2,
                              double radius, double poisson_ratio = 0.45) {
    return {.body = body,
            .poisson_ratio = poisson_ratio,
            .load_case = "press",
            .model = model,
            .relative_l2 = l2,
            .reaction_error = not_known,
            .stiffness = stiffness,
            .reference = "fine",
            .tool_radius_in_edges = radius};
}

KnownCohort cohort_of(int tetrahedra, std::vector<results::CohortError> errors) {
    KnownCohort known{.file = "made_up.h5", .cohort = {}};
    known.cohort.tetrahedra = tetrahedra;
    known.cohort.errors = std::move(errors);
    return known;
}

const BodyInQuestion question{.poisson_ratio = 0.45, .tool_radius_in_edges = 1.0, .tetrahedra = 1000};

TEST(Evidence, IsOfUnseenBodiesAndCountsFailuresAsInfinitelyWrong) {
    auto diverged = error_of("liver_8", "springs", not_known, not_known, 1.0);
    diverged.status = core::SolutionStatus::diverged;
    const std::vector cohorts{cohort_of(1000, {error_of("liver_2", "springs", -0.04, 0.05, 1.0),
                                               error_of("liver_3", "springs", 0.5, 0.5, 1.0), // training
                                               error_of("liver_4", "springs", 0.02, 0.03, 1.0), diverged})};
    const auto evidence = find_evidence(cohorts, question);
    ASSERT_EQ(evidence.models.size(), 1U);
    const auto *springs = evidence.find("springs");
    ASSERT_NE(springs, nullptr);
    EXPECT_EQ(springs->at_tool, 0.04);
    EXPECT_EQ(springs->worst_at_tool, -0.04);
    EXPECT_EQ(springs->relative_l2, 0.05);
    EXPECT_TRUE(std::isinf(springs->worst_relative_l2));
    EXPECT_EQ(springs->num_at_tool, 3U);
    EXPECT_EQ(springs->num_failed, 1U);
    EXPECT_TRUE(std::isnan(springs->large_at_tool));
    EXPECT_TRUE(std::isnan(springs->in_both_at_tool()));
    EXPECT_EQ(evidence.num_bodies, 3U);
    EXPECT_EQ(evidence.reference, "fine");
    EXPECT_EQ(evidence.find("others"), nullptr);
}

TEST(Evidence, SaysHowLargeTheMeshesOfItsBodiesAre) {
    auto known = cohort_of(0, {error_of("liver_2", "springs", -0.04, 0.05, 1.0)});
    known.cohort.bodies.resize(6);
    known.cohort.provenance.git_commit = "0123abc";
    known.cohort.provenance.created = "2026-11-01T00:00:00";
    EXPECT_EQ(
        find_evidence(std::vector{known}, question).sources.front(),
        "made_up.h5: 6 livers of as many tetrahedra as those that ship, `livermark cohort` of 2026-11-01 at commit "
        "0123abc");
    EXPECT_EQ(size_in_words("bodies", 5000), "bodies of about 5000 tetrahedra");
    for (const auto &source : shipped_evidence(question).sources)
        EXPECT_EQ(source.find("about 0 "), std::string::npos) << source;
}

TEST(Evidence, AtTheToolIsOfToolsOfNearlyTheSameRadiusInEdges) {
    std::vector<results::CohortError> errors;
    for (const auto *body : {"a_0", "a_2", "a_4", "a_6", "a_8", "b_0"}) {
        errors.push_back(error_of(body, "springs", 0.04, 0.01, 1.2));
        errors.push_back(error_of(body, "springs", 0.01, 0.01, 4.0)); // a much larger tool
    }
    const std::vector cohorts{cohort_of(1000, errors)};
    EXPECT_DOUBLE_EQ(find_evidence(cohorts, question).find("springs")->at_tool, 0.04);
    EXPECT_DOUBLE_EQ(find_evidence(cohorts, question).largest_radius, 1.2);
    auto large_tool = question;
    large_tool.tool_radius_in_edges = 5.0;
    EXPECT_DOUBLE_EQ(find_evidence(cohorts, large_tool).find("springs")->at_tool, 0.01);
    EXPECT_DOUBLE_EQ(find_evidence(cohorts, large_tool).least_radius, 4.0);
}

TEST(Evidence, LooksFartherAwayWhereTooFewToolsAreNear) {
    const std::vector cohorts{
        cohort_of(1000, {error_of("a_2", "springs", 0.04, 0.01, 1.0), error_of("a_4", "springs", 0.02, 0.01, 9.0)})};
    const auto evidence = find_evidence(cohorts, question);
    EXPECT_EQ(evidence.find("springs")->num_at_tool, 2U);
    EXPECT_DOUBLE_EQ(evidence.largest_radius, 9.0);
}

TEST(Evidence, OfTheDisplacementIsOfTheNearestNumberOfTetrahedra) {
    const std::vector cohorts{cohort_of(1000, {error_of("a_2", "springs", 0.04, 0.08, 1.0)}),
                              cohort_of(16000, {error_of("a_2", "springs", 0.02, 0.03, 1.0)})};
    EXPECT_EQ(find_evidence(cohorts, question).find("springs")->relative_l2, 0.08);
    auto fine = question;
    fine.tetrahedra = 50000;
    EXPECT_EQ(find_evidence(cohorts, fine).find("springs")->relative_l2, 0.03);
    EXPECT_EQ(find_evidence(cohorts, fine).tetrahedra, 16000);
}

TEST(Evidence, IsOfTheNearestPoissonsRatioInEachRegime) {
    auto large = error_of("a_2", "springs", 0.06, 0.07, 1.0, 0.49);
    large.regime = core::Regime::large;
    const std::vector cohorts{cohort_of(1000, {error_of("a_2", "springs", 0.04, 0.08, 1.0, 0.45),
                                               error_of("a_2", "springs", 0.02, 0.03, 1.0, 0.49), large})};
    const auto evidence = find_evidence(cohorts, question);
    EXPECT_EQ(evidence.poisson_ratio, 0.45);
    EXPECT_EQ(evidence.largest_poisson_ratio, 0.49);
    EXPECT_EQ(evidence.large_poisson_ratio, 0.49);
    EXPECT_EQ(evidence.find("springs")->at_tool, 0.04);
    EXPECT_EQ(evidence.find("springs")->in_both_at_tool(), 0.06);
    EXPECT_EQ(evidence.find("springs")->in_both_relative_l2(), 0.08);
}

TEST(Evidence, IsRefusedWhereThereIsNone) {
    tests::expect_input_error([] { find_evidence(std::vector{cohort_of(1000, {})}, question); },
                              {"no errors on unseen bodies", "restore results/cohorts"});
}

TEST(Evidence, ThatShipsKnowsEveryModelInBothRegimes) {
    const auto evidence = shipped_evidence(question);
    for (const auto *model : {"nodal_neo_hookean", "nodal_neo_hookean_f", "edge_neo_hookean", "patch_nodal_volume"}) {
        const auto *error = evidence.find(model);
        ASSERT_NE(error, nullptr) << model;
        EXPECT_GT(error->in_both_at_tool(), 0.0) << model;
        EXPECT_LT(error->in_both_at_tool(), 1.0) << model;
        EXPECT_EQ(error->num_large_failed, 0U) << model;
        EXPECT_GT(error->in_both_relative_l2(), 0.0) << model;
    }
    EXPECT_LT(evidence.find("nodal_neo_hookean")->at_tool, evidence.find("fem_p1")->at_tool);
}

} // namespace
} // namespace livermark::studies
