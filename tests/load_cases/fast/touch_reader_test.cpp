#include <gtest/gtest.h>
#include <string>

#include "core/tool/tool_stiffness.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "tests/bad_input.hpp"
#include "tests/golden.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

const std::string held_block = R"(title = "Touch"
regime = "large"
[[condition]]
patch = "z_min"
displacement = [0.0, 0.0, 0.0]
)";
const std::string touching_ball = R"([touch]
disc = { patch = "z_max", radius = 0.03 }
radius = 0.02
depth = 0.01
friction = 0.3
)";

core::TetraMesh block_to_touch() {
    return tests::box_mesh({0.1, 0.1, 0.1}, {4, 4, 4});
}

core::LoadCase parse_touch(const std::string &text) {
    return load_cases::parse_load_case(text, "touch.toml", block_to_touch());
}

TEST(Touch, BallJustTouchesTheBodyAtRestAndSinksIn) {
    const auto load_case = parse_touch(held_block + touching_ball);
    ASSERT_TRUE(load_case.touching);
    const auto &ball = *load_case.touching;
    EXPECT_LT((ball.start - Vector3(0.05, 0.05, 0.12)).norm(), 1e-9);
    EXPECT_LT((ball.press - Vector3(0.0, 0.0, -0.01)).norm(), 1e-15);
    EXPECT_EQ(ball.friction, 0.3);
    EXPECT_EQ(load_case.constraint_names().at(ball.constraint), "touch");
    EXPECT_EQ(load_case.target_peak_displacement, 0.01);
    EXPECT_TRUE(core::is_driven(load_case));
    const auto places = core::tool_places(block_to_touch(), load_case);
    ASSERT_EQ(places.size(), 1U);
    EXPECT_EQ(places[0].name, "touch");
    EXPECT_EQ(places[0].drive, core::ToolDrive::depth);
    EXPECT_LT((places[0].middle - Vector3(0.05, 0.05, 0.1)).norm(), 1e-9);
}

TEST(Touch, FrictionAndSlideMayBeLeftOut) {
    const auto smooth = parse_touch(held_block + tests::replaced(touching_ball, "friction = 0.3", ""));
    EXPECT_EQ(smooth.touching->friction, 0.0);
    EXPECT_EQ(smooth.touching->slide, Vector3::Zero());
    EXPECT_EQ(parse_touch(held_block + touching_ball + "slide = [0.01, 0.0, 0.0]\n").touching->slide,
              Vector3(0.01, 0.0, 0.0));
    EXPECT_FALSE(parse_touch(held_block + R"([[condition]]
patch = "z_max"
push = 0.01
)")
                     .touching);
}

TEST(Touch, IsRefusedWhereItIsNone) {
    std::string refusals;
    refusals += tests::refusals_after(
        {"regime = \"large\" -> regime = \"small\"", "displacement = [0.0 -> displacement = [0.001",
         "regime -> acceleration = [0.0, 0.0, 1.0]\nregime", "radius = 0.02 -> radius = 0.0",
         "depth = 0.01 -> depth = -0.01", "depth = 0.01 -> depth = 0.041", "friction = 0.3 -> friction = -0.3",
         "friction -> frictoin", "{ patch = \"z_max\" -> { patch = \"z_min\"",
         "{ patch = \"z_max\" -> { patch = \"lid\""},
        held_block + touching_ball, parse_touch);
    refusals +=
        tests::refusal("no radius and no depth", [] { parse_touch(held_block + "[touch]\npatch = \"z_max\"\n"); });
    tests::expect_golden("refusals_of_touching_balls", refusals);
}

} // namespace
} // namespace livermark
