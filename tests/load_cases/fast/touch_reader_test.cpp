#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <string>

#include "core/tool/tool_stiffness.hpp"
#include "load_cases/readers/event_reader.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "tests/bad_input.hpp"
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

std::string with_other_text(std::string text, const std::string &what, const std::string &by) {
    return text.replace(text.find(what), what.size(), by);
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

TEST(Touch, PlateJustTouchesTheBodyAtRestWithItsFace) {
    for (const auto *plate : {"round", "square"}) {
        const auto shaped =
            with_other_text(touching_ball, "radius = 0.02\n", fmt::format("plate = \"{}\"\nsize = 0.02\n", plate));
        const auto touching = parse_touch(held_block + shaped).touching.value();
        EXPECT_EQ(core::to_string(touching.shape.face), std::string(plate));
        EXPECT_EQ(touching.shape.size, 0.02);
        EXPECT_NEAR(touching.shape.radius, 0.002, 1e-15); // a tenth
        EXPECT_LT((touching.shape.axis - Vector3(0.0, 0.0, -1.0)).norm(), 1e-12);
        EXPECT_LT((touching.start - Vector3(0.05, 0.05, 0.102)).norm(), 1e-9);
        EXPECT_LT((touching.first_point() - Vector3(0.05, 0.05, 0.1)).norm(), 1e-9);
        EXPECT_EQ(parse_touch(held_block + shaped + "edge_radius = 0.004\n").touching->shape.radius, 0.004);
    }
}

/// A plate that comes beside a step of the body touches it with its edge, and lower down where that is round.
TEST(Touch, PlateFirstTouchesWhatStandsOut) {
    auto mesh = block_to_touch();
    for (auto &point : mesh.points)
        if (point.z() > 0.099 && point.x() > 0.099)
            point.z() += 0.01;
    const core::ToolShape plate(core::ToolFace::square, 0.02, 0.004, {0.0, 0.0, -1.0});
    const auto touch = load_cases::first_touch(mesh, {0.05, 0.05, 0.1}, {0.0, 0.0, -1.0}, plate);
    // The ramp rises by 0.4 from x = 0.075 on, and the edge has its centres at x = 0.07, 4 mm before the face.
    const double ramp = 0.1 + 0.4 * (0.07 - 0.075) + 0.004 * std::sqrt(1.0 + 0.4 * 0.4);
    const double on_flat = 0.104;
    EXPECT_NEAR(touch.centre.z(), std::max(ramp, on_flat), 2e-4);
    const auto beside = load_cases::first_touch(mesh, {0.07, 0.05, 0.1}, {0.0, 0.0, -1.0}, plate);
    EXPECT_NEAR(beside.centre.z(), 0.1 + 0.4 * (0.09 - 0.075) + 0.004 * std::sqrt(1.0 + 0.4 * 0.4), 2e-4);
}

TEST(Touch, FrictionAndSlideMayBeLeftOut) {
    const auto smooth = parse_touch(held_block + with_other_text(touching_ball, "friction = 0.3", ""));
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
    const auto refused = [](const std::string &text, const std::string &why) {
        tests::expect_input_error([&] { parse_touch(text); }, {why});
    };
    const auto changed = [](const std::string &what, const std::string &by) {
        return held_block + with_other_text(touching_ball, what, by);
    };
    refused(with_other_text(held_block, "\"large\"", "\"small\"") + touching_ball, "write regime = \"large\"");
    refused(with_other_text(held_block, "displacement = [0.0", "displacement = [0.001") + touching_ball,
            "has to be the only load");
    refused(with_other_text(held_block, "regime", "acceleration = [0.0, 0.0, 1.0]\nregime") + touching_ball,
            "has to be the only load");
    refused(changed("radius = 0.02", "radius = 0.0"), "has to be positive");
    refused(changed("depth = 0.01", "depth = -0.01"), "has to be positive");
    const std::string round = "plate = \"round\"\nsize = 0.02";
    refused(changed("radius = 0.02", "size = 0.02"), "is not of a ball");
    refused(changed("radius = 0.02", "radius = 0.02\n" + round), "is not of a plate");
    refused(changed("radius = 0.02", "plate = \"oval\"\nsize = 0.02"), "write \"round\" or \"square\"");
    refused(changed("radius = 0.02", "plate = \"round\""), "size");
    refused(changed("radius = 0.02", "plate = \"round\"\nsize = 0.0"), "has to be positive");
    refused(changed("radius = 0.02", round + "\nedge_radius = -0.001"), "has to be positive");
    refused(with_other_text(changed("depth = 0.01", "depth = 0.05"), "radius = 0.02", round), "a larger size");
    refused(changed("depth = 0.01", "depth = 0.041"), "under the surface");
    refused(changed("friction = 0.3", "friction = -0.3"), "zero or more");
    refused(changed("friction", "frictoin"), "frictoin");
    refused(changed("\"z_max\"", "\"z_min\""), "a constrained place");
    refused(changed("patch = \"z_max\"", "patch = \"lid\""), "lid");
    refused(held_block + "[touch]\npatch = \"z_max\"\n", "things are missing");
}

} // namespace
} // namespace livermark
