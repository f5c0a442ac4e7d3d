#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "load_cases/readers/load_case_reader.hpp"
#include "tests/bad_input.hpp"
#include "tests/golden.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

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
