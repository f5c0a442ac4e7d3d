#include "results/error_bands.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <limits>

#include "support/input_error.hpp"

namespace livermark::results {
namespace {

std::filesystem::path written(const std::string &text) {
    const auto *test = testing::UnitTest::GetInstance()->current_test_info();
    auto path = std::filesystem::path(testing::TempDir()) / (std::string("error_bands_") + test->name() + ".toml");
    std::ofstream(path) << text;
    return path;
}

/// The message with which a text is refused.
std::string refusal(const std::string &text) {
    const auto path = written(text);
    try {
        read_error_bands(path);
    } catch (const support::InputError &error) {
        const std::string message = error.what();
        EXPECT_EQ(message.rfind(path.string(), 0), 0u) << message;
        return message.substr(path.string().size());
    }
    ADD_FAILURE() << "was read: " << text;
    return {};
}

const std::string head = "[[group]]\norigin = \"measured\"\nmargin = 0.02\n";

TEST(ErrorBands, FindsTheBandOfAModelOnAProblem) {
    const auto path = written(head + "[group.relative_l2.liver]\n"
                                     "lloyd = {palpation = 0.31, traction = 0.1}\n"
                                     "uniform = {palpation = 1}\n"
                                     "[[group]]\norigin = \"theory\"\nmargin = 1e-9\n"
                                     "[group.relative_l2.box]\n"
                                     "lloyd = {gravity = 0}\n"
                                     "[group.relative_l2.liver]\n"
                                     "uniform = {traction = 0.2}\n");
    const ErrorBands bands = read_error_bands(path);
    EXPECT_EQ(bands.bands.size(), 5u);
    EXPECT_EQ(bands.find("liver", "palpation", "lloyd"), (ErrorBand{0.31, 0.02, "measured"}));
    EXPECT_EQ(bands.find("liver", "traction", "lloyd"), (ErrorBand{0.1, 0.02, "measured"}));
    EXPECT_EQ(bands.find("liver", "palpation", "uniform"), (ErrorBand{1.0, 0.02, "measured"}));
    EXPECT_EQ(bands.find("box", "gravity", "lloyd"), (ErrorBand{0.0, 1e-9, "theory"}));
    EXPECT_EQ(bands.find("liver", "traction", "uniform"), (ErrorBand{0.2, 1e-9, "theory"}));
    EXPECT_EQ(bands.find("box", "palpation", "lloyd"), std::nullopt);
    EXPECT_EQ(bands.places.at({"liver", "palpation", "uniform"}), path.string() + ":6");
    EXPECT_TRUE(read_error_bands(written("# no model was measured yet\n")).bands.empty());
}

TEST(ErrorBands, RefuseWithLineAndRemedy) {
    const std::string row = "[group.relative_l2.b]\nm = {l = 0.3}\n";
    const auto expect = [](const std::string &text, const std::string &says) {
        const std::string message = refusal(text);
        EXPECT_EQ(message.rfind(says, 0), 0u) << message << "\ninstead of\n" << says;
    };
    expect(head + row + "oops\n", ":6: this is not TOML");
    expect(head + row + "m = {k = 0.3}\n", ":6: this is not TOML");
    expect(head + row + "[[grup]]\n", ":6: unknown key 'grup'; did you mean 'group'?");
    expect("[b.l.m]\nrelative_l2 = 0.3\n", ":1: unknown key 'b'; known are: group");
    expect("[group]\norigin = \"x\"\n", ":1: a group is no list; write [[group]] above");
    expect("group = [3]\n", ":1: this has to be a table; write [[group]] above");
    expect("[[group]]\nmargn = 1\n", ":2: unknown key 'margn'; did you mean 'margin'?");
    expect("[[group]]\norigin = \"x\"\n" + row, ":1: 'margin' is missing");
    expect("[[group]]\nmargin = 0.1\n" + row, ":1: 'origin' is missing");
    expect(head, ":1: 'relative_l2' is missing");
    expect("[[group]]\nmargin = 0.1\norigin = 3\n" + row, ":3: 'origin' has to be a string");
    expect("[[group]]\nmargin = 0.1\norigin = \"\"\n" + row, ":3: 'origin' is empty");
    expect("[[group]]\nmargin = 0\norigin = \"x\"\n" + row, ":2: 'margin' is not positive; give");
    expect("[[group]]\nmargin = nan\norigin = \"x\"\n" + row, ":2: 'margin' has to be a finite number");
    expect(head + "relative_l2 = 0.3\n", ":4: 'relative_l2' has to be a table");
    expect(head + "[group.relative_l2]\nb = 0.3\n", ":5: this has to be a table; write [group.relative_l2.<body>]");
    expect(head + "[group.relative_l2.b]\nm = 0.3\n", ":5: this has to be a table; write <model> =");
    expect(head + "[group.relative_l2.b]\nm = {l = \"0.3\"}\n", ":5: 'l' has to be a finite number");
    expect(head + "[group.relative_l2.b]\nm = {l = true}\n", ":5: 'l' has to be a finite number");
    expect(head + "[group.relative_l2.b]\nm = {l = nan}\n", ":5: 'l' has to be a finite number");
    expect(head + "[group.relative_l2.b]\nm = {l = -0.1}\n", ":5: the error of 'l' is negative; give");
}

/// What happens when a proposed line is pasted and the old one stays.
TEST(ErrorBands, RefuseABandThatIsThereTwice) {
    const std::string row = "[group.relative_l2.b]\nm = {l = 0.3}\n";
    const std::string message = refusal(head + row + head + row);
    EXPECT_EQ(message.rfind(":10: b under l has a band for m already, at ", 0), 0u) << message;
    EXPECT_NE(message.find(":5; keep one of them"), std::string::npos) << message;
}

TEST(ErrorBands, AreReadBackAsTheyWereWritten) {
    const std::map<BandKey, ErrorBand> bands{
        {{"liver", "grasp", "lloyd"}, {1.0 / 3.0, 0.002, "a run"}},
        {{"liver", "grasp", "uniform"}, {0.0, 0.002, "a run"}},
        {{"liver", "traction", "lloyd"}, {3.7718, 0.1, "a run"}},
        {{"my liver", "a \"case\".1", "lloyd"}, {1e-9, 0.002, "another run: \"ü\" \\ ' \n"}},
    };
    EXPECT_EQ(read_error_bands(written(to_toml(bands))).bands, bands);
    EXPECT_EQ(to_toml({}), "");
}

TEST(ErrorBands, HaveALineForEachModelOnABody) {
    EXPECT_EQ(to_toml({{{"liver", "grasp", "lloyd"}, {0.31, 0.002, "a run"}},
                       {{"liver", "traction", "lloyd"}, {0.055, 0.002, "a run"}},
                       {{"liver", "grasp", "uniform"}, {1.0, 0.002, "a run"}}}),
              "[[group]]\norigin = 'a run'\nmargin = 0.002\n\n[group.relative_l2.liver]\n"
              "lloyd = { grasp = 0.31, traction = 0.055 }\nuniform = { grasp = 1 }\n");
}

TEST(ErrorBands, RefuseAFileThatIsMissing) {
    EXPECT_THROW(read_error_bands("/nowhere/error_bands.toml"), support::InputError);
}

TEST(ErrorBand, ContainsItsEndsAndNothingBeyond) {
    const ErrorBand band{0.5, 0.25, ""};
    EXPECT_TRUE(band.contains(0.25));
    EXPECT_TRUE(band.contains(0.75));
    EXPECT_FALSE(band.contains(0.2499999));
    EXPECT_FALSE(band.contains(0.7500001));
    EXPECT_FALSE(band.contains(std::numeric_limits<double>::quiet_NaN()));
    EXPECT_FALSE(band.contains(std::numeric_limits<double>::infinity()));
}

TEST(ErrorBand, IsMissedByASolutionThatIsNotOkOrNotCompared) {
    ModelResult model;
    EXPECT_EQ(meets_band(model), std::nullopt);
    model.band = ErrorBand{0.5, 0.25, ""};
    EXPECT_EQ(meets_band(model), false);
    model.comparison.emplace().relative_l2 = 0.5;
    EXPECT_EQ(meets_band(model), true);
    model.solution.status = core::SolutionStatus::not_converged;
    EXPECT_EQ(meets_band(model), false);
}

} // namespace
} // namespace livermark::results
