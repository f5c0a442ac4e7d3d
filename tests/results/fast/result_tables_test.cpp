// Tables of results: what was reviewed is in tests/golden/, what has to hold is here.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>
#include <sstream>

#include "core/tool/tool_stiffness.hpp"
#include "results/tables/table.hpp"
#include "tests/golden.hpp"
#include "tests/samples/records/sample_result.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::results {
namespace {

using Cells = std::vector<std::string>;
using tests::expect_golden;

constexpr int springs = 1; // of the models of sample_result()

/// The cells of the springs in the first result of a table.
Cells cells_of(const Result &result) {
    return error_table({&result, 1}).rows.at(springs);
}

std::vector<Result> two_results() {
    std::vector<Result> results{tests::sample_result(), tests::sample_result()};
    results[1].problem.load_case.name = "gravity";
    results[1].models.resize(2);
    auto &[name, summary, source, solution, comparison] = results[1].models[springs];
    comparison->relative_l2 = 0.12345;
    comparison->max_error = 0.0012344;
    comparison->reaction_error = 0.07;
    solution.nonlinearity = 0.0123;
    solution.displacement.assign(12, core::Vector3(0.003, 0.0, 0.004));
    return results;
}

TEST(Table, ConvertsUnitsAndShowsFailuresWithTheirReason) {
    const auto text = text_table(two_results());
    expect_golden("table", text);
    expect_golden("table_markdown", markdown_table(two_results()));
    EXPECT_EQ(text.find("nan"), std::string::npos);
}

TEST(Table, HasPathsAndHistoriesInTheOtherRegimes) {
    auto result = tests::along_a_path(tests::sample_result(1000));
    result.problem.load_case.regime = core::Regime::large;
    expect_golden("large_table", to_text(large_table({&result, 1})) + "\n" + to_text(force_table({&result, 1})));
    const auto slow = tests::sample_result(1000);
    expect_golden("slow_table", to_text(slow_table({&slow, 1})));
}

TEST(Table, HasNoControlCharactersOfNames) {
    auto results = two_results();
    results[0].problem.load_case.name = "a\x1b[2Jb\x07";
    results[0].models[1].name = "c\xc2\x9b"
                                "31md\x7f";
    for (const auto &table : {text_table(results), markdown_table(results)}) {
        EXPECT_NE(table.find("a?[2Jb?"), std::string::npos) << table;
        EXPECT_NE(table.find("c??31md?"), std::string::npos) << table;
        for (const char c : table)
            EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20) << static_cast<int>(c);
    }
    EXPECT_EQ(printable("\xc2\xb1 3 \xe2\x82\xac"), "\xc2\xb1 3 \xe2\x82\xac");
    results[0].problem.load_case.name = "a|b"; // which Markdown would take for a column
    EXPECT_NE(markdown_table(results).find("| a\\|b |"), std::string::npos);
}

TEST(Table, MarksWhatFingersFeel) {
    Result result = tests::sample_result();
    auto &places = result.models[springs].comparison->tool.value().places;
    places.resize(2);
    const auto cell = [&](double constrained, double pulled, std::vector<double> path = {}) {
        places[0].stiffness = pulled;
        places[1].stiffness = constrained;
        places[0].path.assign(path.size(), 0.0);
        places[1].path = std::move(path);
        return cells_of(result)[6];
    };
    EXPECT_EQ(cell(0.01, -0.0699), "-7.0");
    EXPECT_EQ(cell(0.01, -0.0701), "-7.0 !");
    EXPECT_EQ(cell(0.5, 0.01), "+50.0 !");
    EXPECT_EQ(cell(std::nan(""), 0.0), "0.0");
    EXPECT_EQ(cell(0.0, 0.0, {0.6, -0.9, 0.1}), "-90.0 !") << "the worst along the path";
    // A load case without a tool has no number, which is not zero.
    std::ranges::fill(result.problem.load_case.condition_on, -1);
    result.problem.load_case.touching.reset();
    for (auto &model : result.models)
        if (model.comparison)
            model.comparison->tool.reset();
    EXPECT_EQ(cells_of(result)[6], "-");
    EXPECT_EQ(text_table({&result, 1}).find("tool: error"), std::string::npos);
}

/// By the radius of its contact, which is smaller than that of the ball, and on its way smaller than at its end.
TEST(Table, WarnsOfBallsThatTouchLessThanHalfAnEdge) {
    Result result = tests::sample_result();
    const auto radii = core::contact_radii_in_edges(result.problem.body->mesh, result.problem.load_case);
    ASSERT_EQ(radii.size(), result.problem.load_case.path.size());
    ASSERT_LT(radii.front(), core::smallest_contact);
    const auto note = note_on_small_contacts({&result, 1});
    ASSERT_TRUE(note);
    EXPECT_NE(
        note->find(fmt::format("pull_and_hang on box touches {:.1f} to {:.1f} edges in radius; where that is below 0.5",
                               radii.front(), radii.back())),
        std::string::npos)
        << *note;
    EXPECT_FALSE(note_on_small_tools({&result, 1})) << "which are not round places";
    result.problem.load_case.touching->shape.radius *= std::pow(1.01 * core::smallest_contact / radii.front(), 2.0);
    EXPECT_FALSE(note_on_small_contacts({&result, 1}));
}

/// A model that is closer to the reference than the reference to the truth is not to be ranked.
TEST(Table, TellsWhoIsWithinTheUncertaintyOfTheReference) {
    Result result = tests::sample_result();
    const auto column = [&] {
        Cells cells;
        for (const auto &row : error_table({&result, 1}).rows)
            cells.push_back(row[5]);
        return cells;
    };
    EXPECT_EQ(column(), (Cells{"19.00", "-", "-", "-"})); // 20 % is not within 19 %
    EXPECT_EQ(text_table({&result, 1}).find("\n*: "), std::string::npos);
    result.reference_uncertainty->relative_l2 = 0.21;
    EXPECT_EQ(column(), (Cells{"21.00", "*", "-", "-"}));
    EXPECT_NE(text_table({&result, 1}).find("\n*: "), std::string::npos);
    result.models[1].solution.status = core::SolutionStatus::not_converged;
    EXPECT_EQ(column(), (Cells{"21.00", "-", "-", "-"}));
    result.models[1].solution.status = core::SolutionStatus::ok;
    result.reference_uncertainty.reset();
    EXPECT_EQ(column(), (Cells{"-", "-", "-", "-"}));
}

TEST(Table, HasLinesOfEqualWidthForATerminal) {
    std::istringstream lines(text_table(two_results()));
    std::string line;
    std::getline(lines, line);
    const auto width = line.size();
    EXPECT_LE(width, 190U); // though a diverged solution moves by 1e30 m
    int count = 1;
    for (; std::getline(lines, line) && !line.empty(); ++count)
        EXPECT_EQ(line.size(), width) << line;
    EXPECT_EQ(count, 8);
}

using Field = std::vector<core::Vector3>;

const auto modes_mesh = tests::box_mesh({0.1, 0.2, 0.1}, {2, 3, 2});

/// Every node moves by the same.
Field constant(const core::Vector3 &value) {
    return Field(modes_mesh.points.size(), value);
}

TEST(ModalAssurance, IsOneForOneShapeAndZeroForOthersThatShareNothing) {
    const auto along = constant({0.0, 1.0, 0.0});
    EXPECT_NEAR(core::modal_assurance(modes_mesh, along, constant({0.0, -3.0, 0.0})), 1.0, 1e-14);
    EXPECT_EQ(core::modal_assurance(modes_mesh, along, constant({1.0, 0.0, 2.0})), 0.0);
    EXPECT_NEAR(core::modal_assurance(modes_mesh, along, constant({1.0, 1.0, 0.0})), 0.5, 1e-14);
}

Field both(Field first, const Field &second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
}

TEST(ModesTable, SetsModelsBesideTheReference) {
    const auto hertz = [](double frequency) { return 2.0 * std::numbers::pi * frequency; };
    Result result{.provenance = {}, .problem = {}, .models = {}};
    result.problem.body = tests::make_body(modes_mesh, {1060.0, 5e3, 0.25});
    result.modes = {
        {"springs", {{hertz(1.1), hertz(3.0)}, both(constant({1.0, 0.0, 0.0}), constant({0.0, 1.0, 0.0})), 0, 0.25}},
        {"measure", {{hertz(1.0), hertz(4.0)}, both(constant({2.0, 0.0, 0.0}), constant({0.0, 0.0, 1.0})), 0, 1.5}}};
    expect_golden("modes", to_text(modes_table(result, "measure")));
    EXPECT_EQ(modes_table(result, "nobody").columns.size(), 3U);
}

/// Changes the body of a result.
void set_poisson_ratio(Result &result, double ratio) {
    auto body = *result.problem.body;
    body.materials.front().poisson_ratio = ratio;
    result.problem.body = std::make_shared<const core::Body>(std::move(body));
}

void set_error(Result &result, double error, double reaction_error) {
    result.models[springs].comparison->relative_l2 = error;
    result.models[springs].comparison->reaction_error = reaction_error;
}

/// Two load cases at 0.3, and one at 0.45.
std::vector<Result> three_results() {
    std::vector<Result> results(3, tests::without_motion(tests::sample_result()));
    results[1].problem.load_case.name = "gravity";
    for (auto &result : results)
        set_poisson_ratio(result, &result == &results[2] ? 0.45 : 0.3);
    set_error(results[0], 0.10, 0.50);
    set_error(results[1], 0.30, 0.07);
    set_error(results[2], 0.25, 0.25);
    results[0].models[springs].solution.explicit_steps = {0.004, 2e-4, "scalar"};
    results[1].models[springs].solution.explicit_steps = {0.003, 1e-4, "scalar"};
    results[2].models[springs].solution.explicit_steps = {0.002, 3e-4, "scalar"};
    return results;
}

Cells row_of(const Layout &layout, const std::string &model) {
    const auto found = std::ranges::find(layout.rows, model, [](const auto &row) { return row.at(1); });
    return found == layout.rows.end() ? Cells{} : *found;
}

TEST(Overview, HasMeansWorstErrorsAndStepsForEachPoissonsRatio) {
    const auto results = three_results();
    // Both load cases have 20 % at the tool; the first by name is shown.
    expect_golden("overview",
                  to_text(overview(results)) + "\n" + to_text(mean_errors(results)) + "\n" + to_text(summary(results)));
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
        set_poisson_ratio(results[r], 0.3);
        set_error(results[r], 0.9, 0.9);
        for (auto &place : results[r].models[springs].comparison->tool.value().places) {
            place.stiffness = 0.9;
            place.path.clear();
        }
    }
    EXPECT_EQ(overview(results).rows, overview(three_results()).rows);
    EXPECT_EQ(mean_errors(results).rows, mean_errors(three_results()).rows);
    const auto row = row_of(summary(results), "springs");
    EXPECT_EQ(row[2], "90.00"); // of the motion, whose load case has the same name
    EXPECT_EQ(row[5], "20.00"); // the mean
    EXPECT_EQ(row[7], row_of(summary(three_results()), "springs")[6]); // and at the tool
}

TEST(Overview, SaysOverHowManyLoadCasesAMeanIsThatIsNotOverAll) {
    auto results = three_results();
    auto guest = results[0].models[springs];
    guest.name = "guest";
    results[0].models.push_back(guest);
    EXPECT_EQ(row_of(overview(results), "guest")[2], "10.00 (1 of 2)");
    EXPECT_EQ(row_of(overview(results), "guest")[9], "-");
    EXPECT_EQ(mean_errors(results).rows.back(), (Cells{"guest", "10.00 (1 of 2)", "20.0 !", "-", "-"}));
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

TEST(ParetoFront, HasWhatNothingElseBeats) {
    const std::vector<CostAndError> points{{1.0, 9.0}, {2.0, 5.0},       {2.0, 6.0},       {3.0, 5.0},
                                           {4.0, 1.0}, {not_known, 0.0}, {0.0, not_known}, {4.0, 1.0}};
    EXPECT_EQ(pareto_front(points), (std::vector<bool>{true, true, false, false, true, false, false, true}));
    EXPECT_TRUE(pareto_front({}).empty());
}

/// A static load case of models that have moved elsewhere.
Result at_rest_with_history() {
    auto result = tests::sample_result();
    result.problem.load_case.release.reset();
    result.problem.load_case.slow_history.reset();
    return result;
}

TEST(Accuracy, OfBodiesAtRestIsTheMeanErrorAndTheCostOfExplicitSteps) {
    std::vector<Result> results(2, at_rest_with_history());
    results[1].problem.load_case.name = "gravity";
    results[0].models[1].comparison->relative_l2 = 0.10;
    results[1].models[1].comparison->relative_l2 = 0.30;
    results[1].models[1].solution.explicit_steps = {0.0025, 1e-4, "scalar"};
    auto faster = results[0].models[1]; // and worse
    faster.name = "faster";
    faster.comparison->relative_l2 = 0.5;
    faster.solution.explicit_steps = {0.005, 1e-4, "scalar"};
    auto dominated = faster;
    dominated.name = "dominated";
    dominated.solution.explicit_steps = {0.001, 1e-4, "scalar"};
    for (auto &result : results)
        result.models.insert(result.models.end(), {faster, dominated});
    results.push_back(results[1]); // a second run of the same is no second load case
    results.push_back(results[1]); // and a multiple of a load counts in no mean
    results.back().problem.load_case.name += "@10";
    for (auto &model : results.back().models)
        if (model.comparison) {
            model.comparison->relative_l2 = 0.9;
            for (auto &place : model.comparison->tool.value().places) {
                place.stiffness = 0.9;
                place.path.clear();
            }
        }
    // 0.8 of the shortest critical step; the reference has an error of its own, and no cost but that of its motion.
    expect_golden("accuracy_at_rest", to_text(static_accuracy(results)));
}

TEST(Accuracy, DoesNotRankAMeanOverSomeOfTheLoadCases) {
    std::vector<Result> results(2, at_rest_with_history());
    results[1].problem.load_case.name = "gravity";
    auto guest = results[0].models[1];
    guest.name = "guest"; // cheaper and better, where it took part
    guest.comparison->relative_l2 = 0.01;
    guest.solution.explicit_steps = {0.01, 1e-4, "scalar"};
    results[0].models.push_back(guest);
    const auto rows = static_accuracy(results).rows;
    ASSERT_EQ(rows.size(), 3U);
    EXPECT_EQ(rows[1].back(), "front");
    EXPECT_EQ(rows[2], (Cells{"box", "guest", "8", "0.0125", "1.00 (1 of 2)", "20.0 !", ""}));
}

TEST(Accuracy, HasNoErrorAtRestWhereOnlyAMotionStartedThere) {
    const auto result = tests::sample_result();
    const auto row = static_accuracy({&result, 1}).rows.at(springs);
    EXPECT_EQ(Cells(row.begin() + 4, row.end()), (Cells{"-", "-", ""}));
}

TEST(Accuracy, InMotionHasARowForEachRun) {
    std::vector<Result> results(2, tests::sample_result());
    auto &longer = *results[1].models[1].solution.history;
    longer.integrator = "hourglass";
    longer.time_step = 0.004;
    longer.solve_seconds = 0.004; // for 0.04 s
    for (auto &result : results)
        result.models[1].comparison->history->relative_l2 = 0.2;
    results[1].motion_uncertainty.reset();
    expect_golden("accuracy_in_motion", to_text(motion_accuracy(results)));
    results[1].models[1].comparison->history->reference = "fem_p2p1_refined_at_rims"; // not to be ranked with the other
    EXPECT_EQ(motion_accuracy(results).rows[0][7], "front");
    EXPECT_EQ(motion_accuracy(results).rows[1].back(), "fem_p2p1_refined_at_rims");
}

} // namespace
} // namespace livermark::results
