// Medians over load cases: what was reviewed is in tests/golden/, what has to hold is here.
#include "results/tables/table.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>

#include "results/one_reference.hpp"
#include "tests/golden.hpp"
#include "tests/samples/records/sample_result.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::results {
namespace {

using Cells = std::vector<std::string>;

constexpr int spring_model = 1; // of the models of sample_result()

/// A static load case without pressure, with the error of the springs and the reference's own uncertainty.
Result named(const std::string &load_case, double error, double uncertainty, double poisson_ratio = 0.45) {
    auto result = tests::without_motion(tests::sample_result());
    result.models.resize(2);
    result.problem.load_case.name = load_case;
    result.models[spring_model].comparison->relative_l2 = error;
    result.reference_uncertainty->relative_l2 = uncertainty;
    auto body = *result.problem.body;
    body.materials.front().poisson_ratio = poisson_ratio;
    result.problem.body = std::make_shared<const core::Body>(std::move(body));
    return result;
}

/// Fixed on one side and pressed on all the others.
core::LoadCase pressed_box(const core::TetraMesh &mesh) {
    auto load_case = tests::empty_load_case(mesh);
    load_case.conditions.push_back({"all around", core::ConditionKind::traction});
    for (int triangle = 0; triangle < mesh.num_boundary_triangles(); ++triangle) {
        load_case.condition_on[triangle] = 0;
        load_case.value[triangle] = -30.0 * core::area_vector(mesh, triangle).normalized();
    }
    tests::prescribe(load_case, mesh, "x_min", {0.0, 0.0, 0.0});
    return load_case;
}

Result under_pressure(double error, double uncertainty, double poisson_ratio = 0.45) {
    auto result = named("gas", error, uncertainty, poisson_ratio);
    result.problem.load_case = pressed_box(result.problem.body->mesh);
    result.problem.load_case.name = "gas";
    return result;
}

void set_stiffness(ModelResult &model, double stiffness) {
    for (auto &place : model.comparison->tool.value().places) {
        place.stiffness = stiffness;
        place.path.clear();
    }
}

/// The cells of a model.
Cells row_of_model(const Layout &layout, const std::string &model) {
    const auto found =
        std::ranges::find_if(layout.rows, [&](const auto &row) { return row[0] == model || row[1] == model; });
    return found == layout.rows.end() ? Cells{} : *found;
}

Cells medians_of(std::span<const Result> results, const std::string &model = "springs") {
    return row_of_model(median_errors(results), model);
}

TEST(MedianErrors, PressureIsOnTheWholeSurfaceIfNoFacetIsFreeAndNoTractionIsTangential) {
    const auto mesh = tests::box_mesh({0.2, 0.1, 0.1}, {2, 1, 1});
    EXPECT_TRUE(is_pressure_on_whole_surface(pressed_box(mesh), mesh));
    auto with_a_free_facet = pressed_box(mesh);
    *std::ranges::find(with_a_free_facet.condition_on, 0) = -1;
    EXPECT_FALSE(is_pressure_on_whole_surface(with_a_free_facet, mesh));
    auto sheared = pressed_box(mesh);
    tests::pull(sheared, mesh, "x_max", {-30.0, 1.0, 0.0});
    EXPECT_FALSE(is_pressure_on_whole_surface(sheared, mesh));
    auto clamped = tests::empty_load_case(mesh);
    for (const auto &patch : mesh.patch_names)
        tests::prescribe(clamped, mesh, patch, {0.0, 0.0, 0.0});
    EXPECT_FALSE(is_pressure_on_whole_surface(clamped, mesh));
}

TEST(MedianErrors, AreTheMiddleOfAnOddNumberAndTheMeanOfTheTwoMiddleOnesOfAnEvenNumber) {
    std::vector<Result> results{named("a", 0.50, 0.01), named("b", 0.02, 0.01), named("c", 0.05, 0.01)};
    EXPECT_EQ(medians_of(results).at(2), "5.00");
    results.push_back(named("d", 0.07, 0.01));
    EXPECT_EQ(medians_of(results).at(2), "6.00");
    EXPECT_EQ(median({3.0, 1.0, 2.0}), 2.0);
    EXPECT_EQ(median({4.0, 1.0, 2.0, 3.0}), 2.5);
    EXPECT_EQ(median({7.0}), 7.0);
}

TEST(Quantile, IsInterpolatedBetweenSortedValues) {
    EXPECT_DOUBLE_EQ(quantile({3.0, 1.0, 2.0}, 0.5), 2.0);
    EXPECT_DOUBLE_EQ(quantile({4.0, 1.0, 2.0, 3.0}, 0.5), 2.5);
    EXPECT_DOUBLE_EQ(quantile({0.0, 10.0}, 0.95), 9.5);
    EXPECT_DOUBLE_EQ(quantile({7.0}, 0.95), 7.0);
}

TEST(MedianErrors, KeepPressureAndPoissonsRatiosApart) {
    const std::vector<Result> results{named("a", 0.04, 0.01), under_pressure(3.77, 0.02), named("b", 0.06, 0.01),
                                      under_pressure(0.20, 0.01, 0.49), named("a", 0.30, 0.01, 0.49)};
    tests::expect_golden("medians", to_text(median_errors(results)) + median_legend(results));
}

TEST(MedianErrors, MarkWhatIsCloserToTheReferenceThanItsOwnUncertainty) {
    const std::vector<Result> results{named("a", 0.004, 0.01), named("b", 0.03, 0.02), named("c", 0.005, 0.01),
                                      under_pressure(0.02, 0.02)};
    // 0.5 % is below the median uncertainty of 1 %; as much as the uncertainty is not below it.
    EXPECT_EQ(medians_of(results), (Cells{"box", "springs", "0.50 *", "20.0 !", "+20.0 ! a", "2.00"}));
    auto unknown = results;
    unknown[1].reference_uncertainty.reset();
    EXPECT_EQ(medians_of(unknown).at(2), "0.50");
}

/// Load cases without a tool count in neither number; pressure on the whole surface only in its own column.
TEST(MedianErrors, HaveTheMedianSizeOfStiffnessAtTheToolAndTheWorstWithItsLoadCase) {
    std::vector<Result> results{named("a", 0.1, 0.01), named("b", 0.1, 0.01), named("c", 0.1, 0.01),
                                named("d", 0.1, 0.01), under_pressure(0.1, 0.01)};
    const std::vector<double> stiffness{-0.12, 0.05, 0.01, std::nan(""), 0.9};
    for (std::size_t r = 0; r < results.size(); ++r)
        set_stiffness(results[r].models[spring_model], stiffness[r]);
    auto row = medians_of(results);
    EXPECT_EQ(row.at(3), "5.0");
    EXPECT_EQ(row.at(4), "-12.0 ! a");
    for (auto &result : results)
        result.models[spring_model].comparison->tool.reset();
    row = medians_of(results);
    EXPECT_EQ(row.at(3), "-");
    EXPECT_EQ(row.at(4), "-");
    EXPECT_NE(median_legend(results).find("!: above 7 %"), std::string::npos);
}

/// References on paths of loads know it under some tools only; a body that is only tilted has no tool.
TEST(MedianErrors, SayUnderHowManyToolsTheReferenceKnowsItsOwnStiffness) {
    std::vector<Result> results{named("a", 0.1, 0.01), named("b", 0.1, 0.01), named("c", 0.1, 0.01)};
    for (const auto r : {1, 2})
        results[r].reference_uncertainty->stiffness.reset();
    const auto &mesh = results[2].problem.body->mesh;
    auto &tilted = results[2].problem.load_case;
    tilted = tests::empty_load_case(mesh);
    tilted.name = "c";
    tilted.acceleration = {1.0, 0.0, 0.0};
    tests::prescribe(tilted, mesh, "x_min", {0.0, 0.0, 0.0});
    EXPECT_EQ(medians_of(results, "fem_p2").at(3), "+- 0.8 (1 of 2)");
}

TEST(MedianErrors, ShowTheStatusOfWhatFailedWhereItFailed) {
    std::vector<Result> results{named("a", 0.10, 0.01), under_pressure(0.20, 0.01)};
    results[1].models[spring_model].solution.status = core::SolutionStatus::diverged;
    EXPECT_EQ(medians_of(results), (Cells{"box", "springs", "10.00", "20.0 !", "+20.0 ! a", "diverged"}));
}

TEST(MedianErrors, CountARepeatedLoadCaseOnceAndLeaveMotionAndMultiplesOut) {
    std::vector<Result> results{named("a", 0.90, 0.01), named("a", 0.10, 0.01), named("a@10", 0.80, 0.01),
                                tests::sample_result()};
    EXPECT_FALSE(has_several_load_cases(results));
    EXPECT_EQ(medians_of(results).at(2), "10.00"); // the last of the two
    EXPECT_FALSE(has_several_load_cases(std::vector<Result>{named("a", 0.1, 0.01, 0.45), named("b", 0.1, 0.01, 0.49)}));
    results.push_back(named("b", 0.30, 0.01));
    EXPECT_TRUE(has_several_load_cases(results));
    EXPECT_TRUE(median_errors(std::vector<Result>{tests::sample_result()}).rows.empty());
}

TEST(MedianErrors, SayOverHowManyLoadCasesTheyAreWhereAModelLacksSome) {
    std::vector<Result> results{named("a", 0.004, 0.01), named("b", 0.30, 0.01), named("c", 0.20, 0.01)};
    results[1].models.resize(1);
    results[2].models.resize(1);
    for (const auto r : {1, 2}) { // somebody else was compared there
        auto other = named("x", 0.5, 0.01).models[spring_model];
        other.name = "other";
        results[r].models.push_back(other);
    }
    const auto layout = median_errors(results);
    EXPECT_EQ(row_of_model(layout, "springs").at(2), "0.40 (1 of 3)"); // and no star
    EXPECT_EQ(row_of_model(layout, "other").at(2), "50.00 (2 of 3)");
    EXPECT_EQ(row_of_model(layout, "fem_p2").at(2), "+- 1.00");
}

/// With springs, and some that are softer under the tool and further off.
Result brief_case(const std::string &load_case, double error, double stiffness, double poisson_ratio = 0.45) {
    auto result = named(load_case, error, 0.01, poisson_ratio);
    result.models.push_back(tests::stiffer(result.models[spring_model]));
    result.models.back().comparison->relative_l2 = 2.0 * error;
    set_stiffness(result.models[spring_model], stiffness);
    set_stiffness(result.models.back(), 0.5 * stiffness);
    return result;
}

/// A model that is right under the tool alone is not among the best.
TEST(BriefTable, HasTwoNumbersForEachModelAndBodyAndNamesTheBestByTheLarger) {
    const std::vector<Result> results{brief_case("a", 0.30, 0.02), brief_case("b", 0.40, -0.04),
                                      brief_case("c", 0.50, 0.12), brief_case("a", 0.40, 0.08, 0.49)};
    tests::expect_golden("brief", to_text(brief(results)) + brief_legend(results));
    const auto best = best_springs(results);
    ASSERT_EQ(best.size(), 2U); // at each of Poisson's ratios
    EXPECT_EQ(best[0].models.front().model, "springs") << "not the one that is nearest under the tool";
}

/// The footnote says what a sign means, so that it is there.
TEST(BriefTable, KeepsTheSignThatAllLoadCasesHave) {
    const auto cell = [](std::vector<double> stiffness) {
        std::vector<Result> results;
        for (const double value : stiffness)
            results.push_back(brief_case(std::string(1, static_cast<char>('a' + results.size())), 0.3, value));
        return row_of_model(brief(results), "springs").at(2);
    };
    EXPECT_EQ(cell({-0.336}), "-33.6 !");
    EXPECT_EQ(cell({0.336}), "+33.6 !");
    EXPECT_EQ(cell({-0.02, -0.03, -0.12}), "-3.0");
    EXPECT_EQ(cell({-0.02, 0.03, -0.12}), "3.0");
    EXPECT_EQ(cell({0.0}), "0.0");
}

TEST(BriefTable, NamesTheBestInPositionWhereNothingHasATool) {
    auto result = brief_case("a", 0.30, 0.02);
    for (auto &model : result.models)
        if (model.comparison)
            model.comparison->tool.reset();
    const auto legend = brief_legend(std::vector{result});
    EXPECT_NE(legend.find(", in position: springs 30.0 %, stiffer 60.0 %\n"), std::string::npos) << legend;
}

/// Motion is no case at rest, so it has no place here.
TEST(BriefTable, HasNoRowsWithoutALoadCaseAtRest) {
    const std::vector<Result> results{tests::sample_result()};
    EXPECT_TRUE(brief(results).rows.empty());
}

} // namespace
} // namespace livermark::results
