#include "results/error_bands.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <limits>

#include "core/input_error.hpp"

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
    } catch (const core::InputError &error) {
        const std::string message = error.what();
        EXPECT_EQ(message.rfind(path.string(), 0), 0u) << message;
        return message.substr(path.string().size());
    }
    ADD_FAILURE() << "was read: " << text;
    return {};
}

TEST(ErrorBands, FindsTheBandOfAModelOnAProblem) {
    const ErrorBands bands = read_error_bands(written("[liver.palpation.lloyd]\n"
                                                      "relative_l2 = 0.31\nmargin = 0.02\norigin = \"measured\"\n"
                                                      "[liver.palpation.uniform]\n"
                                                      "relative_l2 = 1\nmargin = 0.1\norigin = \"measured\"\n"
                                                      "[box.gravity.lloyd]\n"
                                                      "relative_l2 = 0\nmargin = 1e-9\norigin = \"theory\"\n"));
    EXPECT_EQ(bands.bands.size(), 3u);
    EXPECT_EQ(bands.find("liver", "palpation", "lloyd"), (ErrorBand{0.31, 0.02, "measured"}));
    EXPECT_EQ(bands.find("liver", "palpation", "uniform"), (ErrorBand{1.0, 0.1, "measured"}));
    EXPECT_EQ(bands.find("box", "gravity", "lloyd"), (ErrorBand{0.0, 1e-9, "theory"}));
    EXPECT_EQ(bands.find("box", "palpation", "lloyd"), std::nullopt);
    EXPECT_TRUE(read_error_bands(written("# no model was measured yet\n")).bands.empty());
}

TEST(ErrorBands, RefuseWithLineAndRemedy) {
    const std::string table = "[b.l.m]\n";
    const std::string good = "relative_l2 = 0.3\nmargin = 0.1\norigin = \"x\"\n";
    const auto expect = [](const std::string &text, const std::string &says) {
        const std::string message = refusal(text);
        EXPECT_EQ(message.rfind(says, 0), 0u) << message << "\ninstead of\n" << says;
    };
    expect(table + good + "oops\n", ":5: this is not TOML");
    expect(table + good + table + good, ":5: this is not TOML");
    expect(table + good + "margn = 1\n", ":5: unknown key 'margn'; did you mean 'margin'?");
    expect(table + "margin = 0.1\norigin = \"x\"\n", ":1: 'relative_l2' is missing");
    expect(table + "relative_l2 = 0.3\norigin = \"x\"\n", ":1: 'margin' is missing");
    expect(table + "relative_l2 = 0.3\nmargin = 0.1\n", ":1: 'origin' is missing");
    expect(table + "relative_l2 = 0.3\nmargin = 0.1\norigin = 3\n", ":4: 'origin' has to be a string");
    expect(table + "relative_l2 = 0.3\nmargin = 0.1\norigin = \"\"\n", ":4: 'origin' is empty");
    expect(table + "relative_l2 = \"0.3\"\n", ":2: 'relative_l2' has to be a finite number");
    expect(table + "relative_l2 = true\n", ":2: 'relative_l2' has to be a finite number");
    expect(table + "relative_l2 = nan\n", ":2: 'relative_l2' has to be a finite number");
    expect(table + "relative_l2 = -0.1\nmargin = 0.1\norigin = \"x\"\n", ":2: 'relative_l2' is negative; give");
    expect(table + "relative_l2 = 0.1\nmargin = 0\norigin = \"x\"\n", ":3: 'margin' is not positive; give");
    expect("margin = 0.1\n", ":1: bands stand in tables; write");
}

TEST(ErrorBands, RefuseAFileThatIsMissing) {
    EXPECT_THROW(read_error_bands("/nowhere/error_bands.toml"), core::InputError);
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
