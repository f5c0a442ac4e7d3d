#include <gtest/gtest.h>
#include <string>

#include "core/mesh/tetra_mesh.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "tests/bad_input.hpp"
#include "tests/golden.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

const auto cube = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
const std::string held = "[[condition]]\npatch = \"x_min\"\ndisplacement = [0.0, 0.0, 0.0]\n";

core::LoadCase parse_own(const std::string &text) {
    return load_cases::parse_load_case(text, "own.toml", cube);
}

TEST(OwnLoadCase, NeedsConditionsAlone) {
    const auto pulled = parse_own(held + "[[condition]]\npatch = \"x_max\"\nforce = [0.1, 0.0, 0.0]\n");
    EXPECT_EQ(pulled.title, "own");
    EXPECT_DOUBLE_EQ(pulled.target_peak_displacement, 0.01 * core::extent(cube.points)) << "nothing says how far";
    EXPECT_FALSE(pulled.scale_to_target);
    const auto moved = parse_own(held + "[[condition]]\npatch = \"x_max\"\ndisplacement = [0.003, \"free\", 0.004]\n");
    EXPECT_DOUBLE_EQ(moved.target_peak_displacement, 0.005);
    const auto pressed = parse_own(held + "[[condition]]\npatch = \"x_max\"\npress = 0.002\n");
    EXPECT_DOUBLE_EQ(pressed.target_peak_displacement, 0.002);
}

TEST(OwnLoadCase, SaysAllThatIsMissingAtOnceAndFirstWhatIsMisspelt) {
    std::string refusals;
    for (const auto &text :
         {std::string("scale_to_target = true\n[[condition]]\npatch = \"x_min\"\n[[condition]]\npressure = 10.0\n"),
          held + "[release]\n", "regime = \"large\"\n" + held + "[tool]\nduration = 1.0\n",
          std::string("[[condition]]\nptach = \"x_min\"\n")})
        refusals += tests::refusal(text, [&] { parse_own(text); });
    tests::expect_golden("refusals_of_missing_parts", refusals);
}

TEST(OwnLoadCase, HasAToolThatOnlyPressesWhereNoSlideIsGiven) {
    const auto load_case =
        parse_own("regime = \"large\"\n" + held +
                  "[[condition]]\nname = \"finger\"\npatch = \"x_max\"\npush = 0.01\n[tool]\nplace = \"finger\"\n"
                  "press_until = 0.5\nrelease_at = 1.0\nduration = 1.5\nmass_damping = 7.0\n");
    ASSERT_TRUE(load_case.tool);
    EXPECT_EQ(load_case.tool->slide, core::Vector3(0.0, 0.0, 0.0));
    EXPECT_EQ(load_case.tool->num_frames, 90);
    EXPECT_DOUBLE_EQ(load_case.target_peak_displacement, 0.01);
}

} // namespace
} // namespace livermark
