#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <string>
#include <unistd.h>

#include "load_cases/readers/load_case_reader.hpp"
#include "tests/bad_input.hpp"
#include "tests/golden.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

core::LoadCase parse_with_history(const std::string &history, const std::string &above = "",
                                  const std::string &pressure = "pressure = 300.0\n") {
    return load_cases::parse_load_case(above + R"(title = "Press"
[[condition]]
patch = "x_min"
displacement = [0.0, 0.0, 0.0]
[[condition]]
patch = "x_max"
)" + pressure + "[history]\n" + history,
                                       "press.toml", tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2}));
}

const std::string inline_series = "relaxation = { moduli = [0.2, 0.3], times = [1.0, 20.0] }\n";

const std::string let_go = "[release]\nduration = 1.0\noutput_interval = 0.1\nalpha = 1.0\nbeta = 0.0\n"
                           "[[probe]]\nname = \"a\"\npatch = \"x_max\"\n";

TEST(SlowHistoryReader, PressesLinearlyAndHoldsInEverLongerIntervals) {
    const auto load_case = parse_with_history(inline_series + "press = 2.0\nhold = 60.0\n");
    ASSERT_TRUE(load_case.slow_history);
    const auto &history = *load_case.slow_history;
    EXPECT_EQ(history.relaxation.moduli, (std::vector<double>{0.2, 0.3}));
    EXPECT_EQ(history.relaxation.times, (std::vector<double>{1.0, 20.0}));
    ASSERT_EQ(history.times.size(), history.factors.size());
    EXPECT_EQ(history.times.front(), 0.0);
    EXPECT_DOUBLE_EQ(history.times.back(), 62.0);
    EXPECT_EQ(std::ranges::adjacent_find(history.times, std::greater_equal<>()), history.times.end());
    for (int k = 0; k < history.num_records(); ++k)
        EXPECT_NEAR(history.factors[k], std::min(history.times[k] / 2.0, 1.0), 1e-12);
    EXPECT_EQ(history.whole_load_record(), history.num_records() - 1);
    EXPECT_FALSE(history.last_cycle);
    const auto interval = [&](int k) { return history.times[k + 1] - history.times[k]; };
    for (int k = 10; k + 2 < history.num_records(); ++k)
        EXPECT_GT(interval(k + 1), interval(k));
    EXPECT_LT(interval(10), 0.3) << "the stress falls fast at first";
}

TEST(SlowHistoryReader, LetsGoAndRests) {
    const auto history =
        *parse_with_history(inline_series + "press = 1\nhold = 5\nrelease = 0.5\nrest = 10\n").slow_history;
    EXPECT_DOUBLE_EQ(history.times.back(), 16.5);
    EXPECT_EQ(history.factors.back(), 0.0);
    EXPECT_EQ(history.factors[history.whole_load_record()], 1.0);
    EXPECT_DOUBLE_EQ(history.times[history.whole_load_record()], 6.0);
}

TEST(SlowHistoryReader, LetsGoAtOnceWhereTheHistoryEnds) {
    const auto load_case = parse_with_history(inline_series + "press = 1\nhold = 5\n" + let_go);
    ASSERT_TRUE(load_case.release && load_case.slow_history);
    EXPECT_EQ(load_case.slow_history->whole_load_record(), load_case.slow_history->num_records() - 1);
    EXPECT_EQ(load_case.release->num_steps, 10);
}

TEST(SlowHistoryReader, CyclesGoFromNothingToTheWholeLoadAndBack) {
    const auto history = *parse_with_history(inline_series + "frequency = 2.0\ncycles = 3\n").slow_history;
    EXPECT_DOUBLE_EQ(history.times.back(), 1.5);
    EXPECT_EQ(history.factors.back(), 0.0);
    EXPECT_EQ(std::ranges::count(history.factors, 1.0), 3);
    ASSERT_TRUE(history.last_cycle);
    EXPECT_DOUBLE_EQ(history.times[*history.last_cycle], 1.0);
    EXPECT_EQ(history.factors[*history.last_cycle], 0.0);
    EXPECT_DOUBLE_EQ(history.times[history.whole_load_record()], 1.25);
}

TEST(SlowHistoryReader, HasNoPathInTheLargeRegime) {
    const auto load_case = parse_with_history(inline_series + "press = 1\n", "regime = \"large\"\n");
    EXPECT_TRUE(load_case.path.empty());
    EXPECT_EQ(load_case.num_path_points(), load_case.slow_history->times.size());
}

TEST(SlowHistoryReader, ReadsASeriesFromAFileBesideTheLoadCase) {
    const auto file = testing::TempDir() + "/dough_" + std::to_string(getpid()) + ".toml";
    std::ofstream(file) << "title = \"Dough\"\nmoduli = [0.5]\ntimes = [3.0]\nsource = \"a kitchen\"\n";
    const auto history = *parse_with_history("relaxation = \"" + file + "\"\npress = 1\n").slow_history;
    EXPECT_EQ(history.relaxation.moduli, (std::vector<double>{0.5}));
    EXPECT_EQ(history.relaxation.name, "dough_" + std::to_string(getpid()));
}

TEST(SlowHistoryReader, RefusesWhatMakesNoSense) {
    std::string refusals;
    const auto refuse = [&](const std::string &history, const std::string &above = "",
                            const std::string &load = "pressure = 300.0\n") {
        refusals += tests::refusal(above + history, [&] { parse_with_history(history, above, load); });
    };
    const std::string large = "regime = \"large\"\n";
    for (const std::string series : {"moduli = [0.5, 0.5], times = [1.0, 2.0]", "moduli = [-0.1], times = [1.0]",
                                     "moduli = [0.1], times = [1.0, 2.0]", "moduli = [0.1], times = [0.0]",
                                     "moduli = [0.1], times = [1.0], tau = 3"})
        refuse("relaxation = { " + series + " }\npress = 1\n");
    refuse("press = 1\n");
    for (const std::string phases :
         {"", "press = -1\n", "press = 0\n", "press = 1e9\n", "hold = 10\n", "press = 1\nrest = 10\n",
          "press = 1\ncycles = 3\nfrequency = 1\n", "cycles = 2.5\nfrequency = 1\n", "cycles = 2000\nfrequency = 1\n",
          "cycles = 2\nfrequency = 0\n", "pres = 1\n"})
        refuse(inline_series + phases);
    refuse(inline_series + "press = 1\n", large + "path = [0.5, 1.0]\n");
    for (const std::string phases :
         {"press = 1\nrelease = 1\n", "press = 1\nrelease = 1\nrest = 3\n", "frequency = 1\ncycles = 2\n"})
        refuse(inline_series + phases + let_go);
    refuse(inline_series + "press = 1\n" + let_go, large);
    refuse(inline_series + "press = 1\n", "", "displacement = [0.0, 0.0, 0.0]\n");
    tests::expect_golden("refusals_of_histories", refusals);
}

} // namespace
} // namespace livermark
