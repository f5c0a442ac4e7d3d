#include "results/tables/table.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sstream>

#include "core/tool/tool_stiffness.hpp"
#include "results/tables/table_layout.hpp"
#include "results/tables/tool_cells.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::results {
namespace {

std::vector<std::string> lines_of(const std::string &text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);)
        lines.push_back(line);
    return lines;
}

/// The cells of a line of a Markdown table.
std::vector<std::string> cells_of(const std::string &line) {
    std::vector<std::string> cells;
    std::istringstream stream(line.substr(1));
    for (std::string cell; std::getline(stream, cell, '|');)
        cells.push_back(cell.size() > 2 ? cell.substr(1, cell.size() - 2) : "");
    return cells;
}

std::vector<Result> two_results() {
    std::vector<Result> results{tests::sample_result(), tests::sample_result()};
    results[1].problem.load_case.name = "gravity";
    results[1].models.resize(2);
    return results;
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
}

TEST(Table, HasALineForEveryModelInOrder) {
    const auto lines = lines_of(markdown_table(two_results()));
    ASSERT_GE(lines.size(), 8u);
    const std::vector<std::string> models{"fem_p2 (reference)", "springs", "blown_up", "unfinished",
                                          "fem_p2 (reference)", "springs"};
    for (std::size_t m = 0; m < models.size(); ++m) {
        const auto cells = cells_of(lines[m + 2]);
        EXPECT_EQ(cells[0], "box");
        EXPECT_EQ(cells[1], m < 4 ? "pull_and_hang" : "gravity");
        EXPECT_EQ(cells[2], models[m]);
    }
}

TEST(Table, ConvertsUnits) {
    Result result = tests::sample_result();
    core::Comparison &comparison = *result.models[1].comparison;
    comparison.relative_l2 = 0.12345;
    comparison.max_error = 0.0012344;
    comparison.reaction_error = 0.07;
    comparison.energy_error = 0.44;
    result.models[1].solution.nonlinearity = 0.0123;
    result.models[1].solution.displacement.assign(12, core::Vector3(0.003, 0.0, 0.004));
    const auto cells = cells_of(lines_of(markdown_table({&result, 1}))[3]);
    const std::vector<std::string> expected{"box",     "pull_and_hang", "springs", "5.000",  "12.35", "*",
                                            "+20.0 !", "1.234",         "7.00",    "+44.00", "1.23"};
    EXPECT_EQ((std::vector<std::string>(cells.begin(), cells.begin() + 11)), expected);
}

TEST(Table, ShowsThePeakOfTheReferenceAndNoErrors) {
    const Result result = tests::sample_result();
    const auto cells = cells_of(lines_of(markdown_table({&result, 1}))[2]);
    // 0.01 |(0.21, 0.12, 0.13)| = 0.01 sqrt(0.0754) m
    const std::vector<std::string> expected{"box",
                                            "pull_and_hang",
                                            "fem_p2 (reference)",
                                            "2.746",
                                            "-",
                                            "19.00",
                                            "+- 0.8",
                                            "-",
                                            "-",
                                            "-",
                                            "-",
                                            "0.25",
                                            "0.333",
                                            "ok"};
    EXPECT_EQ(cells, expected);
}

TEST(Table, MarksWhatFingersFeelAndExplainsIt) {
    Result result = tests::sample_result();
    auto &tool = result.models[1].comparison->tool.value();
    tool.places.resize(2);
    const auto cell = [&](double held, double pulled) {
        tool.places[0].stiffness = pulled;
        tool.places[1].stiffness = held;
        for (auto &place : tool.places)
            place.path.clear();
        return cells_of(lines_of(markdown_table({&result, 1}))[3])[6];
    };
    EXPECT_EQ(cell(0.01, -0.0699), "-7.0");
    EXPECT_EQ(cell(0.01, -0.0701), "-7.0 !");
    EXPECT_EQ(cell(0.5, 0.01), "+50.0 !");
    EXPECT_EQ(cell(std::nan(""), 0.0), "0.0");
    tool.places[1].path = {0.6, -0.9, 0.1}; // the worst along the path
    tool.places[0].path = {0.0, 0.0, 0.0};
    EXPECT_EQ(cells_of(lines_of(markdown_table({&result, 1}))[3])[6], "-90.0 !");
    const auto table = text_table({&result, 1});
    EXPECT_NE(table.find("!: above 7 %"), std::string::npos) << table;
    EXPECT_NE(table.find("\nradius of the smallest tool in edges: box pull_and_hang "), std::string::npos) << table;
    EXPECT_NE(table.find("\nradius of the contact of the ball (Hertz) in edges, along the path: box pull_and_hang "),
              std::string::npos)
        << table;
}

/// By the radius of its contact, which is smaller than that of the ball, and on its way smaller than at its end.
TEST(Table, WarnsOfBallsThatTouchLessThanAnEdge) {
    Result result = tests::sample_result();
    const auto radii = core::contact_radii_in_edges(result.problem.body->mesh, result.problem.load_case);
    ASSERT_EQ(radii.size(), result.problem.load_case.path.size());
    ASSERT_LT(radii.front(), core::smallest_contact);
    const auto note = note_on_small_contacts({&result, 1});
    ASSERT_TRUE(note);
    EXPECT_NE(
        note->find(fmt::format("pull_and_hang on box touches {:.1f} to {:.1f} edges in radius; where that is below 1",
                               radii.front(), radii.back())),
        std::string::npos)
        << *note;
    EXPECT_FALSE(note_on_small_tools({&result, 1})) << "said once";
    result.problem.load_case.touching->shape.radius *= std::pow(1.01 / radii.front(), 2.0);
    EXPECT_FALSE(note_on_small_contacts({&result, 1}));
}

/// A load case without a tool has no number, which is not zero.
TEST(Table, HasNoStiffnessAtTheToolWithoutOne) {
    Result result = tests::sample_result();
    std::ranges::fill(result.problem.load_case.condition_on, -1);
    result.problem.load_case.touching.reset();
    for (auto &model : result.models)
        if (model.comparison)
            model.comparison->tool.reset();
    const auto cells = cells_of(lines_of(markdown_table({&result, 1}))[3]);
    EXPECT_EQ(cells[6], "-");
    EXPECT_EQ(text_table({&result, 1}).find("tool: stiffness"), std::string::npos);
}

/// A model that is closer to the reference than the reference to the truth is not to be ranked.
TEST(Table, TellsWhoIsWithinTheUncertaintyOfTheReference) {
    Result result = tests::sample_result();
    const auto column = [&] {
        std::vector<std::string> cells;
        const auto lines = lines_of(markdown_table({&result, 1}));
        for (std::size_t m = 0; m < result.models.size(); ++m)
            cells.push_back(cells_of(lines[m + 2])[5]);
        return cells;
    };
    EXPECT_EQ(column(), (std::vector<std::string>{"19.00", "-", "-", "-"})); // 20 % is not within 19 %
    EXPECT_EQ(text_table({&result, 1}).find("\n*: "), std::string::npos);
    result.reference_uncertainty->relative_l2 = 0.21;
    EXPECT_EQ(column(), (std::vector<std::string>{"21.00", "*", "-", "-"}));
    EXPECT_NE(text_table({&result, 1}).find("\n*: "), std::string::npos);
    result.models[1].solution.status = core::SolutionStatus::not_converged;
    EXPECT_EQ(column(), (std::vector<std::string>{"21.00", "-", "-", "-"}));
    result.models[1].solution.status = core::SolutionStatus::ok;
    result.reference_uncertainty.reset();
    EXPECT_EQ(column(), (std::vector<std::string>{"-", "-", "-", "-"}));
}

TEST(Table, ShowsFailuresWithTheirReason) {
    const Result result = tests::sample_result();
    for (const std::string &table : {text_table({&result, 1}), markdown_table({&result, 1})}) {
        EXPECT_NE(table.find("box, pull_and_hang, blown_up: diverged: a node left the room\n"), std::string::npos);
        EXPECT_NE(table.find("box, pull_and_hang, unfinished: not_converged: 100 iterations were not enough\n"),
                  std::string::npos);
        EXPECT_EQ(table.find("nan"), std::string::npos);
    }
    const auto cells = cells_of(lines_of(markdown_table({&result, 1}))[4]);
    EXPECT_EQ(cells[3], "-");
    EXPECT_EQ(cells[4], "-");
    EXPECT_EQ(cells[13], "diverged");
}

TEST(Table, HasLinesOfEqualWidthForATerminal) {
    const auto results = two_results();
    const auto lines = lines_of(text_table(results));
    const std::size_t width = lines[0].size();
    EXPECT_LE(width, 190u); // though a diverged solution moves by 1e30 m
    for (std::size_t l = 0; l < 8; ++l)
        EXPECT_EQ(lines[l].size(), width) << lines[l];
    EXPECT_EQ(lines[8], "");
}

TEST(Table, EscapesWhatMarkdownWouldTakeForAColumn) {
    Result result = tests::sample_result();
    result.problem.load_case.name = "a|b";
    EXPECT_NE(markdown_table({&result, 1}).find("| a\\|b |"), std::string::npos);
}

TEST(Table, SaysHowHistoriesCompareAndWhoHasNone) {
    const Result result = tests::sample_result();
    const auto table = text_table({&result, 1});
    EXPECT_NE(table.find("box, pull_and_hang: the rows are the slow history before the release"), std::string::npos)
        << table;
    EXPECT_NE(table.find("in time: fem_p2 itself is uncertain by 8.00 %, "), std::string::npos) << table;
    EXPECT_NE(table.find("springs 20.00 % off fem_p2 (amplitude +20.0 %, 0.0 ms late)"), std::string::npos) << table;
    EXPECT_NE(table.find("unfinished gives no motion"), std::string::npos) << table;
    Result still = result;
    still.problem.load_case.release.reset();
    EXPECT_EQ(text_table({&still, 1}).find("static start"), std::string::npos);
}

} // namespace
} // namespace livermark::results
