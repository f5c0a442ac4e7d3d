#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "core/tool/needle/needle.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/event_reader.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "tests/bad_input.hpp"
#include "tests/golden.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

const auto small_cube = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
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
    return load_cases::parse_load_case(text, "poke.toml", small_cube);
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
    auto refusals = tests::refusals_after(
        {"place = \"finger\" -> place = \"thumb\"", "slide_from = 0.6 -> slide_from = 0.4",
         "release_at = 1.1 -> release_at = 1.105", "mass_damping = 7.0 -> mass_damping = -7.0",
         "frame_rate -> frame_rat", "mass_damping = 7.0 -> mass_damping = 7.0\nradius = 0.0",
         "regime = \"large\" -> regime = \"small\"", "displacement = [0.0 -> displacement = [0.001",
         "regime -> acceleration = [0.0, 0.0, 1.0]\nregime"},
        poke_conditions + poking_tool, parse_poke);
    refusals += tests::refusal("a ball without a radius", [] {
        load_cases::with_touching_ball(parse_poke(poke_conditions + poking_tool), small_cube, 0.0);
    });
    refusals += tests::refusal("a ball that is not pushed", [] {
        const auto held = tests::replaced(poke_conditions, "push = 0.01", "displacement = [0.0, 0.0, 0.0]");
        load_cases::with_touching_ball(parse_poke(held + poking_tool + "radius = 0.012\n"), small_cube, 0.0);
    });
    tests::expect_golden("refusals_of_tools", refusals);
}

/// It comes the way that the place is pushed, and just touches what is there.
TEST(MovingBall, BeginsWhereItTouchesThePlaceThatItsToolPushes) {
    const auto ball =
        load_cases::with_touching_ball(parse_poke(poke_conditions + poking_tool + "radius = 0.012\n"), small_cube, 0.3);
    ASSERT_TRUE(ball.touching);
    EXPECT_EQ(ball.touching->shape.radius, 0.012);
    EXPECT_EQ(ball.touching->friction, 0.3);
    EXPECT_EQ(ball.constraint_names()[ball.touching->constraint], "finger");
    EXPECT_LT((ball.touching->start - core::Vector3(0.112, 0.05, 0.05)).norm(), 1e-9);
    EXPECT_LT((ball.touching->press - core::Vector3(-0.01, 0.0, 0.0)).norm(), 1e-15);
    EXPECT_EQ(ball.touching->constraint, ball.tool->constraint);
    for (int f = 0; f < small_cube.num_boundary_triangles(); ++f)
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

TEST(Touch, PlateJustTouchesTheBodyAtRestWithItsFace) {
    for (const auto *plate : {"round", "square"}) {
        const auto shaped =
            tests::replaced(touching_ball, "radius = 0.02\n", fmt::format("plate = \"{}\"\nsize = 0.02\n", plate));
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

/// A block that is held at a side which neither of two jaws touches.
std::string block_between_jaws() {
    return tests::replaced(held_block, "z_min", "x_min");
}

TEST(Touch, JawsComeFromBothSidesOfTheBody) {
    const auto load_case = parse_touch(block_between_jaws() + touching_ball + "jaws = true\n");
    const auto &ball = load_case.touching.value();
    ASSERT_TRUE(ball.between);
    EXPECT_LT((*ball.between - Vector3(0.05, 0.05, 0.05)).norm(), 1e-9);
    EXPECT_LT((ball.start - Vector3(0.05, 0.05, 0.12)).norm(), 1e-9);
    EXPECT_LT((ball.other_centre(ball.start) - Vector3(0.05, 0.05, -0.02)).norm(), 1e-9);
    const auto names = load_case.constraint_names();
    ASSERT_EQ(names.size(), 3U);
    EXPECT_EQ(names[ball.constraint], "touch");
    EXPECT_EQ(names[ball.constraint + 1], "other jaw");
    const auto places = core::tool_places(block_to_touch(), load_case);
    ASSERT_EQ(places.size(), 2U);
    EXPECT_EQ(places[1].name, "other jaw");
    EXPECT_EQ(places[1].drive, core::ToolDrive::depth);
    EXPECT_EQ(places[1].constraint, ball.constraint + 1);
    EXPECT_LT((places[1].middle - Vector3(0.05, 0.05, 0.0)).norm(), 1e-9);
    EXPECT_EQ(places[1].radius, places[0].radius);
    EXPECT_FALSE(parse_touch(held_block + touching_ball + "jaws = false\n").touching->between);
}

/// A lower side that is steep is touched beside the line along which both balls close.
TEST(Touch, SecondJawJustTouchesWhatIsThere) {
    auto mesh = block_to_touch();
    for (auto &point : mesh.points)
        point.z() -= point.z() < 1e-9 ? 0.5 * point.x() : 0.0;
    const auto load_case =
        load_cases::parse_load_case(block_between_jaws() + touching_ball + "jaws = true\n", "touch.toml", mesh);
    const auto &ball = load_case.touching.value();
    // The centre is below the plane z = -x / 2 by the radius over the cosine of its slope.
    const double below = 0.025 + 0.02 * std::sqrt(1.0 + 0.5 * 0.5);
    EXPECT_LT((ball.other_centre(ball.start) - Vector3(0.05, 0.05, -below)).norm(), 1e-9);
}

TEST(Touch, IsRefusedWhereItIsNone) {
    auto refusals = tests::refusals_after(
        {"regime = \"large\" -> regime = \"small\"", "displacement = [0.0 -> displacement = [0.001",
         "regime -> acceleration = [0.0, 0.0, 1.0]\nregime", "radius = 0.02 -> radius = 0.0",
         "depth = 0.01 -> depth = -0.01", "depth = 0.01 -> depth = 0.041", "friction = 0.3 -> friction = -0.3",
         "friction -> frictoin", "{ patch = \"z_max\" -> { patch = \"z_min\"",
         "{ patch = \"z_max\" -> { patch = \"lid\"", "radius = 0.02 -> size = 0.02",
         "radius = 0.02 -> radius = 0.02\nplate = \"round\"\nsize = 0.02",
         "radius = 0.02 -> plate = \"oval\"\nsize = 0.02", "radius = 0.02 -> plate = \"round\"",
         "radius = 0.02 -> plate = \"round\"\nsize = 0.0",
         "radius = 0.02 -> plate = \"round\"\nsize = 0.02\nedge_radius = -0.001",
         "radius = 0.02\ndepth = 0.01 -> plate = \"round\"\nsize = 0.02\ndepth = 0.05"},
        held_block + touching_ball, parse_touch);
    refusals += tests::refusals_after({"friction = 0.3 -> jaws = true"}, held_block + touching_ball, parse_touch);
    refusals +=
        tests::refusals_after({"friction = 0.3 -> jaws = 2", "friction = 0.3 -> jaws = true\nslide = [0.01, 0.0, 0.0]",
                               "radius = 0.02 -> jaws = true\nplate = \"round\"\nsize = 0.02",
                               "radius = 0.02\ndepth = 0.01 -> jaws = true\nradius = 0.03\ndepth = 0.051"},
                              block_between_jaws() + touching_ball, parse_touch);
    refusals +=
        tests::refusal("no radius and no depth", [] { parse_touch(held_block + "[touch]\npatch = \"z_max\"\n"); });
    tests::expect_golden("refusals_of_touching_balls", refusals);
}

const std::string held_box = R"(title = "Needle"
target_peak_displacement = 0.01
[[condition]]
patch = "z_min"
displacement = [0.0, 0.0, 0.0]
)";
const std::string box_needle = R"([[needle]]
name = "down"
entry = "z_max"
target = [0.05, 0.04, 0.05]
diameter = 0.001
spread = 0.01
toughness = 150.0
friction = 12.0
)";

class Needles : public testing::Test {
  protected:
    std::vector<core::Needle> read(const std::string &text) {
        std::ofstream(file_) << text;
        return load_cases::read_needles(file_, body_, load_cases::read_load_case(file_, body_.mesh));
    }
    void TearDown() override { std::filesystem::remove(file_); }

    core::Body body_ = *tests::make_body(tests::box_mesh({0.1, 0.08, 0.1}, {4, 4, 4}), {1000.0, 5000.0, 0.45});
    std::filesystem::path file_ =
        std::filesystem::temp_directory_path() /
        (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + "_needle.toml");
};

TEST_F(Needles, GoFromThePointOfAPatchThatIsNearestToTheirTarget) {
    const auto needles = read(held_box + box_needle);
    ASSERT_EQ(needles.size(), 1U);
    const auto &needle = needles.front();
    EXPECT_LT((needle.entry - core::Vector3(0.05, 0.04, 0.1)).norm(), 1e-12);
    EXPECT_DOUBLE_EQ(needle.depth(), 0.05);
    EXPECT_DOUBLE_EQ(needle.tip_force(), 0.15);
    EXPECT_DOUBLE_EQ(needle.puncture_force, 0.15) << "a nick was made first";
    EXPECT_EQ(needle.side_softness(0.003), 0.0) << "it is rigid";
    const auto soft = read(held_box + box_needle + "side_stiffness = 1e5\n").front();
    EXPECT_DOUBLE_EQ(soft.side_softness(0.002), 1.0 / 200.0);
}

TEST_F(Needles, GoToTheCentroidOfARegionOrToADepth) {
    const auto to_region = read(held_box + tests::replaced(box_needle, "[0.05, 0.04, 0.05]", "\"solid\""));
    EXPECT_LT((to_region.front().target - core::Vector3(0.05, 0.04, 0.05)).norm(), 1e-12);
    const auto to_depth = read(held_box + tests::replaced(box_needle, "target = [0.05, 0.04, 0.05]", "depth = 0.03"));
    EXPECT_LT((to_depth.front().target - core::Vector3(0.05, 0.04, 0.07)).norm(), 1e-12);
}

TEST_F(Needles, AreRefusedWhereTheyCannotBe) {
    const auto good = held_box + box_needle;
    const auto read_it = [&](const std::string &text) { read(text); };
    auto refusals = tests::refusals_after({"0.04, 0.05] -> 0.04, 0.1101]",
                                           "0.04, 0.05] -> 0.04, -0.01]",
                                           "[0.05, 0.04, 0.05] -> [50.0, 40.0, 50.0]",
                                           "0.04, 0.05] -> 0.04, 0.005]",
                                           "0.04, 0.05] -> 0.04, 0.095]",
                                           "\"z_max\" -> \"z_min\"",
                                           "\"z_max\" -> [0.05, 0.04, 0.2]",
                                           "\"z_max\" -> \"dome\"",
                                           "[0.05, 0.04, 0.05] -> \"tumour_1\"",
                                           "target = [0.05, 0.04, 0.05] -> target = [0.05, 0.04, 0.05]\ndepth = 0.05",
                                           "diameter = 0.001 -> diameter = 0.0",
                                           "diameter = 0.001 -> diameter = 1.27",
                                           "toughness = 150.0 -> toughness = 0.0",
                                           "friction = 12.0 -> friction = -1.0",
                                           "friction = 12.0 -> friction = 12.0\npuncture_force = 0.1",
                                           "friction = 12.0 -> friction = 12.0\nside_stiffness = 0.0",
                                           "friction = 12.0 -> friction = 12.0\nstep = 0.000001",
                                           "friction = 12.0 -> friction = 12.0\nspeed = 1.0",
                                           "spread = 0.01 -> spread = 0.0004",
                                           "spread = 0.01 -> spread = 0.0006",
                                           "name = \"down\"\n -> ",
                                           "displacement = [0.0 -> displacement = [0.1"},
                                          good, read_it, file_.parent_path().string());
    const auto twice = good + box_needle;
    auto other = twice;
    other.replace(other.rfind("\"down\""), 6, "\"again\"");
    for (const auto &[wrong, text] : {std::pair{"twice", twice}, {"twice under two names", other}, {"none", held_box}})
        refusals += tests::refusal(
            wrong, [&] { read(text); }, file_.parent_path().string());
    tests::expect_golden("refusals_of_needles", refusals);
}

/// The bound is not far too large, and below it places are lost.
TEST_F(Needles, HavePlacesInTheBodyWhereTheirSpreadIsTaken) {
    auto needle = read(held_box + box_needle).front();
    needle.target.z() = 1e-9; // the last places are outside
    const double least = core::smallest_spread(needle, body_.mesh);
    constexpr std::size_t num_shifts = 8, stride = 16; // other places at each shift: all of them take a minute
    for (std::size_t shift = 0; shift < num_shifts; ++shift) {
        needle.entry.x() = needle.target.x() = 0.05 + 0.0007 * static_cast<double>(shift);
        needle.spread = least;
        const auto places = core::needle_line(needle).places;
        ASSERT_GT(places.size(), stride);
        for (std::size_t i = places.size() - 1 - shift; i < places.size(); i -= stride)
            EXPECT_NO_THROW(core::points_of(places[i], body_.mesh));
    }
    needle.spread = 0.05 * least;
    EXPECT_ANY_THROW(core::nodal_weights(core::needle_line(needle).places, body_.mesh));
}

TEST_F(Needles, MayBeGivenInMillimetres) {
    auto text = "unit = \"mm\"\n" + held_box + box_needle;
    for (const auto &[from, to] : {std::pair{"displacement = 0.01", "displacement = 10"},
                                   {"[0.05, 0.04, 0.05]", "[50, 40.0, 50]"},
                                   {"0.001", "1"},
                                   {"spread = 0.01", "spread = 10"}})
        text = tests::replaced(text, from, to);
    const auto found = read(text).front(), wanted = read(held_box + box_needle).front();
    EXPECT_LT((found.target - wanted.target).norm() + (found.entry - wanted.entry).norm(), 1e-12);
    EXPECT_DOUBLE_EQ(found.diameter, wanted.diameter);
    EXPECT_DOUBLE_EQ(found.spread, wanted.spread);
    EXPECT_EQ(found.toughness, wanted.toughness);
}

} // namespace
} // namespace livermark
