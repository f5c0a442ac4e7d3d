#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "core/support/input_error.hpp"
#include "meshes/generators/box_generator.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/springs/springs.hpp"
#include "studies/advise/advise.hpp"
#include "studies/models/model_table.hpp"
#include "studies/study.hpp"
#include "tests/bad_input.hpp"

namespace livermark::studies {
namespace {

/// A block of 90 x 60 x 60 mm; with a lump, the middle of it is a region of ten times the stiffness.
core::Body block(bool has_lump, double edge = 0.02) {
    core::Body body{.name = "block",
                    .mesh = meshes::generate_box({0.09, 0.06, 0.06}, edge, meshes::BoxTopology::body_centred),
                    .materials = {{1000.0, 5000.0, 0.45}}};
    if (has_lump) {
        body.mesh.region_names.emplace_back("lump");
        body.materials.push_back({1000.0, 50000.0, 0.45});
        for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t) {
            core::Vector3 centre = core::Vector3::Zero();
            for (const int node : body.mesh.tetrahedra[t])
                centre += body.mesh.points[node] / 4.0;
            body.mesh.region[t] = (centre - core::Vector3(0.045, 0.03, 0.03)).norm() < 0.012 ? 1 : 0;
        }
    }
    return body;
}

bool warns_of(const Advice &advice, const std::string &about) {
    return std::ranges::find(advice.caveats, about, &Caveat::about) != advice.caveats.end();
}

TEST(BodyFigures, SayWhatABodyIs) {
    const auto body = block(true);
    const auto figures = body_figures(body, 0.01);
    EXPECT_NEAR(figures.mesh.volume, 0.09 * 0.06 * 0.06, 1e-12);
    ASSERT_EQ(figures.regions.size(), 2U);
    EXPECT_EQ(figures.main_region, 0U);
    EXPECT_NEAR(figures.regions[0].volume + figures.regions[1].volume, figures.mesh.volume, 1e-12);
    EXPECT_EQ(figures.regions[0].num_tetrahedra + figures.regions[1].num_tetrahedra, figures.mesh.num_tetrahedra);
    EXPECT_EQ(figures.regions[1].num_parts, 1);
    EXPECT_EQ(figures.regions[1].smallest_part_tetrahedra, figures.regions[1].num_tetrahedra);
    EXPECT_LT(figures.regions[1].smallest_part_in_edges, 3.0);
    EXPECT_DOUBLE_EQ(figures.tool_radius_in_edges(), 0.01 / figures.surface_edge);
    EXPECT_EQ(figures.material().young_modulus, 5000.0);
}

TEST(BodyFigures, CountPartsThatTouchAtNoFace) {
    auto body = block(true);
    std::ranges::fill(body.mesh.region, 0);
    body.mesh.region.front() = body.mesh.region.back() = 1; // two corners
    const auto figures = body_figures(body, 0.01);
    EXPECT_EQ(figures.regions[1].num_parts, 2);
    EXPECT_EQ(figures.regions[1].smallest_part_tetrahedra, 1);
}

TEST(BodyFigures, FindWhatIsOneLayerThick) {
    core::Body plate = block(false);
    plate.mesh = meshes::generate_box({0.1, 0.1, 0.01}, 0.012, meshes::BoxTopology::kuhn);
    EXPECT_NEAR(body_figures(plate, 0.01).thin_part, 1.0, 1e-12);
    EXPECT_LT(body_figures(block(false, 0.012), 0.01).thin_part, 0.2);
}

TEST(StepCost, IsThatOfTheHighestFrequencyOfTheFreeBody) {
    const auto body = std::make_shared<const core::Body>(block(false));
    for (const auto *name : {"lloyd", "nodal_neo_hookean", "edge_neo_hookean"}) {
        const auto known = models::all_models();
        const auto springs = models::springs_of(support::find_named(known, name, "model"), body);
        ASSERT_TRUE(springs);
        const auto cost = step_cost(*body, springs->body);
        const auto nothing = core::with_free_surface({}, body->mesh);
        const auto free = msm::nodal_conditions({body, nothing}, springs->body.node_mass);
        const double omega = msm::largest_angular_frequency(springs->body, body->mesh.points, free);
        EXPECT_NEAR(cost.critical_time_step * omega, 2.0, 1e-9) << name;
        EXPECT_LT(cost.safe_time_step(), cost.critical_time_step) << name;
        EXPECT_GE(cost.steps_per_frame() * cost.safe_time_step(), frame) << name;
        EXPECT_LT((cost.steps_per_frame() - 1) * cost.safe_time_step(), frame) << name;
        EXPECT_GT(cost.seconds_per_step, 0.0) << name;
        EXPECT_TRUE(cost.is_on_vector_units) << name;
    }
}

TEST(Advice, RanksThreeModelsByTheWorseOfSmallAndLargeLoads) {
    const auto advice = advise(block(false), {}, {});
    ASSERT_EQ(advice.touch.size(), num_ranked);
    ASSERT_EQ(advice.position.size(), num_ranked);
    for (std::size_t m = 1; m < num_ranked; ++m) {
        EXPECT_LE(advice.touch[m - 1].error.in_both_at_tool(), advice.touch[m].error.in_both_at_tool());
        EXPECT_LE(advice.position[m - 1].error.in_both_relative_l2(), advice.position[m].error.in_both_relative_l2());
    }
    ASSERT_TRUE(advice.linear_tetrahedra);
    EXPECT_GT(advice.linear_tetrahedra->at_tool, advice.touch[0].error.at_tool);
    EXPECT_EQ(advice.caveats.size(), num_ranked);
    EXPECT_TRUE(std::ranges::is_sorted(advice.caveats, std::ranges::greater(), &Caveat::weight));
}

TEST(Advice, NamesModelsWhoseSpringsHaveOneStiffnessOnEachEdge) {
    const auto body = std::make_shared<const core::Body>(block(false));
    const auto advice = advise(*body, {}, {});
    const auto known = models::all_models();
    ASSERT_FALSE(advice.uncoupled.empty());
    for (const auto &model : advice.uncoupled) {
        const auto springs = models::springs_of(support::find_named(known, model.error.model, "model"), body);
        ASSERT_TRUE(springs);
        EXPECT_EQ(springs->springs.stiffness.size(), springs->springs.edges.size()) << model.error.model;
        EXPECT_FALSE(springs->springs.edges.empty()) << model.error.model;
        EXPECT_GT(model.cost.critical_time_step, 0.0);
    }
    for (std::size_t m = 1; m < advice.uncoupled.size(); ++m)
        EXPECT_FALSE(advice.uncoupled[m].error.in_both_at_tool() < advice.uncoupled[m - 1].error.in_both_at_tool());
    EXPECT_NE(to_json(advice).find("\"uncoupled\""), std::string::npos);
}

TEST(Advice, LeavesOutWhatTakesLongerThanTheBudget) {
    // Real times change from one look to the next: here each model that is looked at takes a millisecond more.
    const auto advise_within = [](std::optional<double> budget) {
        int looked_at = 0;
        const auto find = [&](const core::Body &, const msm::ElasticBody &) {
            return StepCost{.critical_time_step = 2.0 * frame, .seconds_per_step = 1e-3 * ++looked_at};
        };
        return advise(block(false), {.budget = budget, .find_cost = find}, {});
    };
    const auto all = advise_within(std::nullopt);
    EXPECT_TRUE(all.over_budget.empty());
    const auto some = advise_within(1.5e-3);
    EXPECT_FALSE(some.over_budget.empty());
    ASSERT_EQ(some.touch.size(), 1U);
    EXPECT_EQ(some.touch[0].error.model, all.touch[0].error.model);
    tests::expect_input_error([&] { advise_within(0.5e-3); },
                              {"--budget", "every model takes longer", "give more time"});
}

TEST(Advice, WarnsOfWhatIsSpecialOfABody) {
    const auto coarse = advise(block(false, 0.03), {.tool_radius = 0.005}, {});
    EXPECT_EQ(coarse.caveats.front().about, "tool");

    auto nearly_incompressible = block(false);
    nearly_incompressible.materials[0].poisson_ratio = 0.4995;
    EXPECT_EQ(advise(nearly_incompressible, {.tool_radius = 0.05}, {}).caveats.front().about, "poisson_ratio");

    const auto with_lump = advise(block(true), {.tool_radius = 0.05}, {});
    EXPECT_TRUE(warns_of(with_lump, "lesions"));
    EXPECT_TRUE(warns_of(with_lump, "stiff_parts"));
    EXPECT_FALSE(warns_of(with_lump, "tool"));
    EXPECT_TRUE(warns_of(advise(block(false), {.tool_radius = 0.05, .is_material_assumed = true}, {}), "material"));
}

TEST(Advice, IsAlsoJsonWithoutNan) {
    auto advice = advise(block(false), {}, {});
    advice.touch[0].error.at_tool = ExpectedError::nan;
    const auto text = to_json(advice);
    EXPECT_EQ(text.find("nan"), std::string::npos);
    for (const auto *key : {"\"body\"", "\"touch\"", "\"position\"", "\"caveats\"", "\"evidence\"", "\"time_step\""})
        EXPECT_NE(text.find(key), std::string::npos) << key;
}

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
