#include "results/one_reference.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <vector>

#include "core/tool/tool_stiffness.hpp"
#include "results/records/cohort.hpp"
#include "results/tables/table.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::results {
namespace {

/// A static result whose errors are against a reference of that name.
Result against(const std::string &reference, core::Regime regime = core::Regime::small) {
    auto result = tests::without_motion(tests::sample_result());
    result.problem.load_case.regime = regime;
    result.models[0].name = reference;
    for (auto &model : result.models)
        if (model.comparison)
            model.comparison->reference = reference;
    result.reference_uncertainty->reference = reference;
    result.reference_uncertainty->refined = "fem_p2p1_refined";
    return result;
}

Result without_reference() {
    auto result = against("fem_p2p1");
    result.models[0].solution.status = core::SolutionStatus::not_converged;
    for (auto &model : result.models)
        model.comparison.reset();
    result.reference_uncertainty.reset();
    return result;
}

/// The same with a reference that moves so many times as far as the load case was meant to.
Result moving_beyond_target(double factor) {
    auto result = against("fem_p2p1");
    result.problem.load_case.target_peak_displacement = peak_of_reference(result) / factor;
    return result;
}

std::vector<std::size_t> sizes_of(const std::vector<std::vector<Result>> &groups) {
    std::vector<std::size_t> sizes;
    for (const auto &group : groups)
        sizes.push_back(group.size());
    return sizes;
}

TEST(OneReference, IsOnRefinedMeshesWhereTheFileSaysSo) {
    EXPECT_FALSE(is_reference_on_mesh(against("fem_p2p1_refined")));
    EXPECT_TRUE(is_reference_on_mesh(against("fem_p2p1")));
    auto unknown = against("fem_p2p1");
    unknown.reference_uncertainty.reset();
    EXPECT_TRUE(is_reference_on_mesh(unknown));
    EXPECT_FALSE(is_reference_on_mesh(without_reference()));
    EXPECT_EQ(reference_of(without_reference()), "");
}

TEST(OneReference, StandsAboveTheTablesInASentence) {
    const auto sentence = [](const Result &result) { return reference_sentence({&result, 1}); };
    EXPECT_EQ(sentence(against("fem_p2p1_refined")),
              "Errors are against fem_p2p1_refined, which was solved on refined meshes; +- is its own uncertainty.");
    auto unknown = against("fem_p2p1");
    unknown.reference_uncertainty.reset();
    EXPECT_EQ(sentence(unknown), "Errors are against fem_p2p1, which was solved on the mesh of the models itself; its "
                                 "own error is not known.");
    EXPECT_EQ(sentence(without_reference()), "Nothing is compared, because no reference has a solution.");
}

TEST(OneReference, IsNeverBesideAnotherInOneGroup) {
    const std::vector<Result> results{against("fem_p2p1_neo_hookean", core::Regime::large), against("fem_p2p1_refined"),
                                      against("fem_p2p1"), without_reference(), against("fem_p2p1_refined")};
    const auto groups = groups_by_reference(results);
    ASSERT_EQ(sizes_of(groups), (std::vector<std::size_t>{3, 1, 1})); // what has none is with the first
    EXPECT_EQ(reference_of(groups[0][0]), "fem_p2p1_refined");
    EXPECT_EQ(reference_of(groups[1][0]), "fem_p2p1");
    EXPECT_EQ(groups[2][0].problem.load_case.regime, core::Regime::large);
    EXPECT_TRUE(groups_by_reference({}).empty());
    EXPECT_EQ(groups_by_reference(std::vector{without_reference()}).size(), 1u);
}

TEST(OneReference, CallsNothingOkWhereItWasNotFound) {
    const auto result = without_reference();
    EXPECT_EQ(shown_status(result.models[0], result), "not_converged");
    EXPECT_EQ(shown_status(result.models[1], result), "not compared");
    EXPECT_FALSE(counts_in_means(result));
    const auto remarks = result_remarks({&result, 1});
    ASSERT_EQ(remarks.size(), 1u);
    EXPECT_EQ(remarks[0],
              "box, nu 0.45, pull_and_hang: no reference has a solution, so no model is compared; blown_up: "
              "a node left the room; unfinished: 100 iterations were not enough");
    EXPECT_EQ(text_table({&result, 1}).find("  ok "), std::string::npos);
}

/// After a ball has slid off there are no ratios, so no model ranks by one.
TEST(OneReference, RanksNobodyWhereItIsAtRestAtTheEnd) {
    auto result = against("fem_p2p1_neo_hookean", core::Regime::large);
    EXPECT_FALSE(ends_at_rest(result));
    EXPECT_TRUE(counts_in_means(result));
    for (auto &model : result.models)
        if (model.comparison)
            model.comparison->relative_l2 = std::nan("");
    result.problem.load_case.touching = core::TouchingTool{.shape = 0.012};
    EXPECT_TRUE(ends_at_rest(result));
    EXPECT_FALSE(counts_in_means(result));
    EXPECT_EQ(shown_status(result.models[1], result), "nothing touches");
    EXPECT_EQ(shown_status(result.models[2], result), "diverged");
    const auto remarks = result_remarks({&result, 1});
    ASSERT_EQ(remarks.size(), 1u);
    EXPECT_EQ(remarks[0],
              "box, nu 0.45, pull_and_hang: nothing touches at the end, where fem_p2p1_neo_hookean is at rest, "
              "so there are no ratios and no model is ranked; give a shorter 'slide' or a larger 'depth'");
    result.problem.load_case.touching.reset();
    EXPECT_EQ(shown_status(result.models[1], result), "at rest");
}

TEST(OneReference, SaysWhyThereIsNone) {
    auto result = without_reference();
    result.models[0].solution.message = "no equilibrium beyond 87.7 % of the load; take a smaller load";
    const auto remarks = result_remarks({&result, 1});
    ASSERT_EQ(remarks.size(), 1u);
    EXPECT_NE(remarks[0].find("no model is compared; fem_p2p1: no equilibrium beyond 87.7 % of the load"),
              std::string::npos)
        << remarks[0];
}

TEST(OneReference, IsNotMissingWhereItIsAlone) {
    auto alone = against("fem_p2p1");
    alone.models.resize(1);
    alone.reference_uncertainty.reset();
    EXPECT_EQ(reference_sentence({&alone, 1}), "Nothing is compared, because fem_p2p1 is the reference itself and no "
                                               "other model was run; name one with --model.");
    EXPECT_EQ(shown_status(alone.models[0], alone), "reference");
    ASSERT_EQ(result_remarks({&alone, 1}).size(), 1u);
    EXPECT_NE(result_remarks({&alone, 1})[0].find("fem_p2p1 is the reference"), std::string::npos);
}

TEST(Regime, IsLeftByALoadThatMovesTheBodyFarBeyondItsTarget) {
    const auto inside = moving_beyond_target(2.9), outside = moving_beyond_target(3.1);
    EXPECT_FALSE(leaves_regime(inside));
    EXPECT_TRUE(counts_in_means(inside));
    EXPECT_EQ(shown_status(inside.models[1], inside), "ok");
    EXPECT_TRUE(result_remarks({&inside, 1}).empty());

    EXPECT_TRUE(leaves_regime(outside));
    EXPECT_FALSE(counts_in_means(outside));
    EXPECT_EQ(shown_status(outside.models[0], outside), "out of regime"); // the reference as well
    EXPECT_EQ(shown_status(outside.models[1], outside), "out of regime");
    EXPECT_EQ(shown_status(outside.models[2], outside), "diverged");
    const auto remarks = result_remarks({&outside, 1});
    ASSERT_EQ(remarks.size(), 1u);
    EXPECT_TRUE(remarks[0].starts_with("box, nu 0.45, pull_and_hang moves 2.75 mm where 0.886 mm were meant"))
        << remarks[0];
    EXPECT_NE(text_table({&outside, 1}).find("out of regime"), std::string::npos);
    EXPECT_EQ(text_table({&outside, 1}).find("  ok "), std::string::npos);
}

TEST(Regime, IsMarkedInTheSummaryAndCountsInNoCohortWhereItIsLeft) {
    auto outside = moving_beyond_target(4.0), inside = moving_beyond_target(1.0);
    const auto rows = summary({&outside, 1}).rows;
    EXPECT_TRUE(rows.at(1).at(2).ends_with(" !")) << rows[1][2];
    EXPECT_EQ(rows[1][3], "-"); // the mean
    for (auto *const result : {&outside, &inside}) {
        auto body = *result->problem.body;
        body.name = "box_1";
        result->problem.body = std::make_shared<const core::Body>(std::move(body));
    }
    EXPECT_TRUE(cohort_errors({&outside, 1}).empty());
    ASSERT_FALSE(cohort_errors({&inside, 1}).empty());
    EXPECT_EQ(cohort_errors({&inside, 1}).front().reference, "fem_p2p1");
    const auto places = core::tool_places(inside.problem.body->mesh, inside.problem.load_case);
    EXPECT_EQ(cohort_errors({&inside, 1}).front().tool_radius_in_edges, core::radius_in_edges(places));
}

TEST(Regime, IsNotLeftByWhatIsSmallForTheBodyNorByLargeDeformations) {
    auto tiny = moving_beyond_target(10.0);
    for (auto &displacement : tiny.models[0].solution.displacement)
        displacement *= 0.5; // still five times the target, but below a hundredth of the box
    EXPECT_FALSE(leaves_regime(tiny));
    auto large = moving_beyond_target(10.0);
    large.problem.load_case.regime = core::Regime::large;
    EXPECT_FALSE(leaves_regime(large));
}

} // namespace
} // namespace livermark::results
