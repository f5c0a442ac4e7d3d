#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <unistd.h>
#include <variant>
#include <vector>

#include "core/load_case.hpp"
#include "core/support/files.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/readers/event_reader.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "tests/bad_input.hpp"
#include "tests/golden.hpp"
#include "tests/samples/even_foundation.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

TEST(Events, HaveAReaderForEachKind) {
    const auto num_read =
        std::ranges::count_if(load_cases::all_events(), [](const auto &event) { return event.begin || event.read; });
    EXPECT_EQ(num_read, static_cast<std::ptrdiff_t>(std::variant_size_v<core::EventKind>));
}

TEST(Events, AreInTheLoadCasesOfTheirFolder) {
    int num_seen = 0;
    for (const auto &event : load_cases::all_events())
        if (event.folder)
            for (const auto &entry : std::filesystem::directory_iterator(support::root_folder() / event.folder)) {
                const auto kind = load_cases::load_case_kind(entry.path());
                EXPECT_TRUE(kind.is_for(event.command)) << entry.path();
                EXPECT_GE(kind.depends_on_time, event.in_time) << entry.path();
                ++num_seen;
            }
    EXPECT_GT(num_seen, 0);
}

TEST(EventSets, KnowTheKindsOfALoadCase) {
    core::LoadCase load_case;
    EXPECT_TRUE(load_case.kinds().empty());
    EXPECT_FALSE(load_case.in_time());
    load_case.touching = core::TouchingTool{.shape = 0.01, .press = {0.0, 0.0, -0.002}};
    EXPECT_TRUE(load_case.kinds().has<core::TouchingTool>());
    EXPECT_FALSE(load_case.in_time()) << "contact is a part of the static solution";
    EXPECT_EQ(load_case.contact_depth(), 0.002);
    load_case.slow_history = core::SlowHistory{};
    EXPECT_TRUE(load_case.in_time());
    const auto both = core::EventSet::of<core::SlowHistory, core::TouchingTool>();
    EXPECT_TRUE(both.has_all_of(load_case.kinds()));
    EXPECT_TRUE(core::EventSet::all().has_all_of(both));
    EXPECT_FALSE((core::EventSet::of<core::SlowHistory, core::Release, core::ToolMotion>().has_all_of(both)));
}

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

const std::string standing = R"(title = "Stand"
regime = "large"
[[condition]]
patch = "x_min"
displacement = [0.0, 0.0, 0.0]
[[condition]]
patch = "x_max"
pressure = 300.0
[foundation]
patch = "z_min"
stiffness = 1e5
)";

core::LoadCase parse_standing(const std::string &text) {
    return load_cases::parse_load_case(text, "stand.toml", tests::box_mesh({0.1, 0.1, 0.1}, {4, 4, 4}));
}

TEST(Foundation, BearsThePlaceThatItNames) {
    const auto load_case = parse_standing(standing);
    const auto &foundation = load_case.foundation.value();
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {4, 4, 4});
    EXPECT_EQ(foundation.facets.size(), 32U);
    EXPECT_TRUE(std::ranges::is_sorted(foundation.facets));
    for (const int f : foundation.facets)
        EXPECT_EQ(mesh.patch_names[mesh.boundary_patch[f]], "z_min");
    EXPECT_EQ(foundation, tests::even_foundation(foundation.facets, 1e5, false));
    const auto along_normal = parse_standing(standing + "normal_only = true\n");
    EXPECT_EQ(along_normal.foundation, tests::even_foundation(foundation.facets, 1e5, true));
    EXPECT_FALSE(core::are_statically_equal(load_case, along_normal));
    EXPECT_FALSE(load_case.in_time());
}

TEST(Foundation, IsThatOfBothRegimes) {
    const auto small = parse_standing(tests::replaced(standing, "regime = \"large\"", ""));
    EXPECT_EQ(small.regime, core::Regime::small);
    EXPECT_EQ(small.foundation, parse_standing(standing).foundation);
}

TEST(Foundation, IsNoLoad) {
    const auto load_case = parse_standing(standing);
    EXPECT_EQ(core::scaled(load_case, 0.5).foundation, load_case.foundation);
    EXPECT_EQ(core::cut_short(load_case, 0.5).foundation, load_case.foundation);
    EXPECT_FALSE(core::is_driven(parse_standing(tests::replaced(standing, "300.0", "0.0"))));
}

/// Whatever facets come near a disc.
TEST(Foundation, OfADiscHasTheStiffnessOfItsArea) {
    const auto foundation =
        parse_standing(tests::replaced(standing, "patch = \"z_min\"", "disc = { patch = \"z_min\", radius = 0.03 }"))
            .foundation.value();
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {4, 4, 4});
    double stiffness = 0.0;
    for (std::size_t which = 0; which < foundation.facets.size(); ++which)
        stiffness += foundation.stiffness[which] * core::area_vector(mesh, foundation.facets[which]).norm();
    EXPECT_NEAR(stiffness, 1e5 * std::numbers::pi * 0.03 * 0.03, 1e-9);
}

/// A facet in both has the springs of the first.
TEST(Foundation, OfSeveralPlacesHasTheSpringsOfEach) {
    const auto foundation =
        parse_standing(tests::replaced(standing, "[foundation]", "[[foundation]]") + R"([[foundation]]
patches = ["z_min", "z_max"]
stiffness = 2e5
normal_only = true
)")
            .foundation.value();
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {4, 4, 4});
    ASSERT_EQ(foundation.facets.size(), 64U);
    EXPECT_TRUE(std::ranges::is_sorted(foundation.facets));
    for (std::size_t which = 0; which < foundation.facets.size(); ++which) {
        const bool is_first = mesh.patch_names[mesh.boundary_patch[foundation.facets[which]]] == "z_min";
        EXPECT_EQ(foundation.stiffness[which], is_first ? 1e5 : 2e5);
        EXPECT_EQ(foundation.normal_only[which], is_first ? 0 : 1);
    }
}

TEST(Foundation, IsRefusedWhereItIsNone) {
    tests::expect_golden(
        "refusals_of_foundations",
        tests::refusals_after(
            {"stiffness = 1e5 -> stiffness = -1e5", "stiffness -> stifness", "patch = \"z_min\" -> patch = \"x_min\"",
             "patch = \"z_min\" -> disc = { patch = \"z_min\", radius = 0.03, profile = \"round\" }",
             "regime -> scale_to_target = true\ntarget_peak_displacement = 0.001\nregime",
             "[foundation] -> [history]\nrelaxation = { moduli = [0.2], times = [1.0] }\npress = 1.0\n[foundation]",
             "regime = \"large\" -> [release]\nduration = 1.0\noutput_interval = 0.1\nalpha = 1.0\nbeta = 0.0\n"
             "[[probe]]\nname = \"end\"\npatch = \"x_max\""},
            standing, parse_standing));
}

const std::string conditions = R"(title = "Blow"
target_peak_displacement = 0.02
[[condition]]
patch = "x_min"
displacement = [0.0, 0.0, 0.0]
[[condition]]
patch = "x_max"
)";

core::LoadCase parse_on_a_block(const std::string &above, const std::string &below) {
    return load_cases::parse_load_case(above + conditions + below, "blow.toml",
                                       tests::box_mesh({0.1, 0.1, 0.1}, {3, 3, 3}));
}

TEST(Regime, IsSmallAndWithoutAPathUnlessTheFileSaysSo) {
    const auto load_case = parse_on_a_block("", "pressure = 300.0\n");
    EXPECT_EQ(load_case.regime, core::Regime::small);
    EXPECT_TRUE(load_case.path.empty());
    EXPECT_FALSE(load_case.has(core::ConditionKind::pressure));
}

TEST(Regime, LargeHasFivePointsOrThoseOfTheFile) {
    const std::string large = "regime = \"large\"\n";
    EXPECT_EQ(parse_on_a_block(large, "pressure = 300.0\n").path, (std::vector{0.2, 0.4, 0.6, 0.8, 1.0}));
    EXPECT_EQ(parse_on_a_block(large + "path = [0.25, 1]\n", "pressure = 300.0\n").path, (std::vector{0.25, 1.0}));
}

TEST(Regime, AFollowerPressureIsThePressureAtRestWithAMark) {
    const auto dead = parse_on_a_block("regime = \"large\"\n", "pressure = 300.0\n");
    const auto follower = parse_on_a_block("regime = \"large\"\n", "follower_pressure = 300.0\n");
    EXPECT_EQ(dead.condition_on, follower.condition_on);
    int marked = 0;
    for (int f = 0; f < dead.num_facets(); ++f) {
        EXPECT_EQ(follower.follows_surface(f), follower.is_loaded(f));
        EXPECT_FALSE(dead.follows_surface(f));
        marked += follower.follows_surface(f) ? 1 : 0;
        if (follower.follows_surface(f)) {
            EXPECT_EQ(follower.value[f], dead.value[f]);
        }
    }
    EXPECT_EQ(marked, 18);
    EXPECT_FALSE(core::are_statically_equal(dead, follower));
}

TEST(Regime, LargeMayBeLetGoAtTheEndOfItsPath) {
    const auto load_case = parse_on_a_block("regime = \"large\"\n", R"(traction = [0.0, 0.0, 300.0]
[release]
duration = 1.0
output_interval = 0.1
alpha = 1.0
beta = 0.001
[[probe]]
name = "end"
patch = "x_max"
)");
    EXPECT_EQ(load_case.path.size(), 5U);
    ASSERT_TRUE(load_case.release);
    EXPECT_EQ(load_case.release->num_steps, 10);
}

TEST(Regime, RefusesWhatMakesNoSenseAndSaysWhere) {
    std::string refusals;
    const std::string large = "regime = \"large\"\n";
    for (const auto &above :
         {std::string("regime = \"huge\"\n"), std::string("path = [0.5, 1.0]\n"), large + "path = [0.5]\n",
          large + "path = [0.5, 0.4, 1.0]\n", large + "path = [0.0, 1.0]\n", large + "path = [0.5, nan, 1.0]\n"})
        refusals += tests::refusal(above, [&] { parse_on_a_block(above, "pressure = 300.0\n"); });
    refusals += tests::refusal("follower_pressure", [] { parse_on_a_block("", "follower_pressure = 300.0\n"); });
    tests::expect_golden("refusals_of_regimes", refusals);
}

} // namespace
} // namespace livermark
