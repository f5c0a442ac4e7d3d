#include <gtest/gtest.h>
#include <string>

#include "load_cases/readers/load_case_reader.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

const std::string poke_conditions = R"(title = "Poke"
regime = "large"
target_peak_displacement = 0.02
[[condition]]
patch = "x_min"
displacement = [0.0, 0.0, 0.0]
[[condition]]
name = "finger"
patch = "x_max"
push = 0.01
)";
const std::string poking_tool = R"([tool]
place = "finger"
press_until = 0.5
slide = [0.0, 0.01, 0.0]
slide_from = 0.6
slide_until = 1.0
release_at = 1.1
duration = 1.6
frame_rate = 60.0
mass_damping = 7.0
)";

core::LoadCase parse_poke(const std::string &text) {
    return load_cases::parse_load_case(text, "poke.toml", tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2}));
}

std::string with_other_words(std::string text, const std::string &what, const std::string &by) {
    return text.replace(text.find(what), what.size(), by);
}

TEST(Tool, MovesThePlaceThatItNames) {
    const auto load_case = parse_poke(poke_conditions + poking_tool);
    ASSERT_TRUE(load_case.tool);
    EXPECT_EQ(load_case.constraint_names()[load_case.tool->constraint], "finger");
    EXPECT_EQ(load_case.tool->num_frames, 96);
    EXPECT_DOUBLE_EQ(load_case.tool->frame_interval, 1.0 / 60.0);
    EXPECT_EQ(load_case.tool->slide, core::Vector3(0.0, 0.01, 0.0));
    EXPECT_EQ(load_case.tool->mass_damping, 7.0);
    EXPECT_FALSE(parse_poke(poke_conditions).tool);
}

TEST(Tool, IsRefusedWhereItIsNone) {
    const auto refused = [](const std::string &text, const std::string &why) {
        tests::expect_input_error([&] { parse_poke(text); }, {why});
    };
    refused(poke_conditions + with_other_words(poking_tool, "\"finger\"", "\"thumb\""),
            "no [[condition]] with a displacement has the name 'thumb'");
    refused(poke_conditions + with_other_words(poking_tool, "slide_from = 0.6", "slide_from = 0.4"), "have to ascend");
    refused(poke_conditions + with_other_words(poking_tool, "release_at = 1.1", "release_at = 1.105"),
            "whole numbers of frames");
    refused(poke_conditions + with_other_words(poking_tool, "mass_damping = 7.0", "mass_damping = -7.0"),
            "zero or more");
    refused(poke_conditions + with_other_words(poking_tool, "frame_rate", "frame_rat"), "frame_rat");
    refused(poke_conditions + poking_tool + "radius = 0.0\n", "has to be positive");
    refused(with_other_words(poke_conditions, "\"large\"", "\"small\"") + poking_tool, "large regime");
    refused(with_other_words(poke_conditions, "displacement = [0.0", "displacement = [0.001") + poking_tool,
            "constrain all other places to zero");
    refused(with_other_words(poke_conditions, "regime", "acceleration = [0.0, 0.0, 1.0]\nregime") + poking_tool,
            "from rest");
}

/// It comes the way that the place is pushed, and just touches what is there.
TEST(MovingBall, BeginsWhereItTouchesThePlaceThatItsToolPushes) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
    const auto ball =
        load_cases::with_touching_ball(parse_poke(poke_conditions + poking_tool + "radius = 0.012\n"), mesh, 0.3);
    ASSERT_TRUE(ball.touching);
    EXPECT_EQ(ball.touching->shape.radius, 0.012);
    EXPECT_EQ(ball.touching->friction, 0.3);
    EXPECT_EQ(ball.constraint_names()[ball.touching->constraint], "finger");
    EXPECT_LT((ball.touching->start - core::Vector3(0.112, 0.05, 0.05)).norm(), 1e-9);
    EXPECT_LT((ball.touching->press - core::Vector3(-0.01, 0.0, 0.0)).norm(), 1e-15);
    EXPECT_EQ(ball.touching->constraint, ball.tool->constraint);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        EXPECT_NE(ball.constraint_on(f), ball.tool->constraint) << "the place is not free";
}

TEST(MovingBall, MayBeAPlate) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
    const auto plate = load_cases::with_touching_ball(
        parse_poke(poke_conditions + poking_tool + "plate = \"square\"\nsize = 0.02\nedge_radius = 0.003\n"), mesh,
        0.0);
    const auto &shape = plate.touching.value().shape;
    EXPECT_EQ(shape, core::ToolShape(core::ToolFace::square, 0.02, 0.003, {-0.01, 0.0, 0.0}));
    EXPECT_LT((plate.touching->start - core::Vector3(0.103, 0.05, 0.05)).norm(), 1e-9);
}

TEST(MovingBall, IsRefusedWhereItsToolIsNoneOrPushesNothing) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
    tests::expect_input_error(
        [&] { load_cases::with_touching_ball(parse_poke(poke_conditions + poking_tool), mesh, 0.0); },
        {"the [tool] has no radius"});
    tests::expect_input_error(
        [&] {
            load_cases::with_touching_ball(
                parse_poke(with_other_words(poke_conditions, "push = 0.01", "displacement = [0.0, 0.0, 0.0]") +
                           poking_tool + "radius = 0.012\n"),
                mesh, 0.0);
        },
        {"is not pushed"});
}

} // namespace
} // namespace livermark
