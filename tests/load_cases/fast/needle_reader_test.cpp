#include "load_cases/readers/load_case_reader.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "core/tool/needle/needle_line.hpp"
#include "load_cases/places/selector.hpp"
#include "tests/bad_input.hpp"
#include "tests/golden.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

constexpr auto held_box = R"(title = "Needle"
target_peak_displacement = 0.01
[[condition]]
patch = "z_min"
displacement = [0.0, 0.0, 0.0]
)";
constexpr auto box_needle = R"([[needle]]
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
    const auto needles = read(std::string(held_box) + box_needle);
    ASSERT_EQ(needles.size(), 1U);
    const auto &needle = needles.front();
    EXPECT_LT((needle.entry - core::Vector3(0.05, 0.04, 0.1)).norm(), 1e-12);
    EXPECT_DOUBLE_EQ(needle.depth(), 0.05);
    EXPECT_DOUBLE_EQ(needle.tip_force(), 0.15);
    EXPECT_DOUBLE_EQ(needle.puncture_force, 0.15) << "a nick was made first";
}

TEST_F(Needles, GoToTheCentroidOfARegionOrToADepth) {
    auto text = std::string(box_needle);
    text.replace(text.find("[0.05, 0.04, 0.05]"), 18, "\"solid\"");
    const auto to_region = read(held_box + text);
    EXPECT_LT((to_region.front().target - core::Vector3(0.05, 0.04, 0.05)).norm(), 1e-12);
    text.replace(text.find("target = \"solid\""), 16, "depth = 0.03");
    const auto to_depth = read(held_box + text);
    EXPECT_LT((to_depth.front().target - core::Vector3(0.05, 0.04, 0.07)).norm(), 1e-12);
}

TEST_F(Needles, AreRefusedWhereTheyCannotBe) {
    const auto good = std::string(held_box) + box_needle;
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
                                           "friction = 12.0 -> friction = 12.0\nstep = 0.000001",
                                           "friction = 12.0 -> friction = 12.0\nspeed = 1.0",
                                           "spread = 0.01 -> spread = 0.0004",
                                           "spread = 0.01 -> spread = 0.0006",
                                           "name = \"down\"\n -> ",
                                           "displacement = [0.0 -> displacement = [0.1"},
                                          good, read_it, file_.parent_path().string());
    const auto twice = good + box_needle;
    refusals += tests::refusal(
        "twice", [&] { read(twice); }, file_.parent_path().string());
    refusals += tests::refusal(
        "twice under two names",
        [&] {
            auto other = twice;
            read(other.replace(other.rfind("\"down\""), 6, "\"again\""));
        },
        file_.parent_path().string());
    refusals += tests::refusal(
        "none", [&] { read(held_box); }, file_.parent_path().string());
    tests::expect_golden("refusals_of_needles", refusals);
}

/// The bound is not far too large, and below it places are lost.
TEST_F(Needles, HavePlacesInTheBodyWhereTheirSpreadIsTaken) {
    auto needle = read(std::string(held_box) + box_needle).front();
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
    auto text = std::string(box_needle);
    for (const auto &[from, to] :
         {std::pair{"[0.05, 0.04, 0.05]", "[50, 40.0, 50]"}, {"0.001", "1"}, {"spread = 0.01", "spread = 10"}})
        text.replace(text.find(from), std::string(from).size(), to);
    auto held = std::string(held_box);
    held.replace(held.find("0.01"), 4, "10");
    const auto found = read("unit = \"mm\"\n" + held + text).front(),
               wanted = read(std::string(held_box) + box_needle).front();
    EXPECT_LT((found.target - wanted.target).norm() + (found.entry - wanted.entry).norm(), 1e-12);
    EXPECT_DOUBLE_EQ(found.diameter, wanted.diameter);
    EXPECT_DOUBLE_EQ(found.spread, wanted.spread);
    EXPECT_EQ(found.toughness, wanted.toughness);
}

} // namespace
} // namespace livermark
