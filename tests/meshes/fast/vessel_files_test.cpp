#include "meshes/io/vessel_files.hpp"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>

#include "meshes/generators/liver_shape.hpp"
#include "meshes/generators/liver_vessels.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/bodies_with_vessels.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

namespace vessels = tests::vessels;

class VesselFile : public testing::Test {
  protected:
    core::VesselTree read(const std::string &text, double metres = 1.0) const {
        std::ofstream(file_) << text;
        return meshes::read_swc(file_, metres);
    }
    void expect_refusal(const std::string &text, const std::string &words) const {
        tests::expect_input_error([&] { read(text); }, {"vessels.swc", words});
    }
    const std::filesystem::path file_ = std::filesystem::path(testing::TempDir()) / "vessels.swc";
};

} // namespace

TEST_F(VesselFile, IsReadAsItWasWritten) {
    const auto found = read(meshes::swc_text(vessels::tree, "two lines"));
    ASSERT_EQ(found.points.size(), vessels::tree.points.size());
    EXPECT_EQ(found.segments, vessels::tree.segments);
    for (std::size_t p = 0; p < found.points.size(); ++p) {
        EXPECT_LT((found.points[p] - vessels::tree.points[p]).norm(), 1e-8);
        EXPECT_NEAR(found.radius[p], vessels::tree.radius[p], 1e-8);
    }
    EXPECT_EQ(found.wall_ratio, meshes::usual_wall_ratio);
}

TEST_F(VesselFile, OfOtherProgramsIsRead) {
    const auto found =
        read("# millimetres\r\n\r\n 7 3 0 0 0 2.5 -1\r\n 5 3 10 0 0 2 7\r\n12 3 20 5.5 -1e1 1.5 5\n", 1e-3);
    ASSERT_EQ(found.segments.size(), 2U);
    EXPECT_EQ(found.segments[1], (std::array{1, 2}));
    EXPECT_LT((found.points[2] - core::Vector3(0.02, 0.0055, -0.01)).norm(), 1e-12);
    EXPECT_NEAR(found.radius[0], 2.5e-3, 1e-15);
}

TEST_F(VesselFile, IsRefusedWhereItIsNone) {
    expect_refusal("1 0 0 0 0 0.001 -1\n2 0 0 0 1 0.001\n", "line 2");
    expect_refusal("1 0 0 0 0 0.001 -1\n2 0 0 0 nan 0.001 1\n", "line 2");
    expect_refusal("1 0 0 0 0 0 -1\n", "has to be positive");
    expect_refusal("1 0 0 0 0 0.001 -1\n1 0 0 0 1 0.001 1\n", "second of a point 1");
    expect_refusal("1 0 0 0 0 0.001 -1\n2 0 0 0 1 0.001 3\n", "behind point 3");
    expect_refusal("1 0 0 0 0 0.001 1\n", "behind point 1");
    expect_refusal("1 0 0 0 0 0.001 -1\n2 0 0 0 0 0.001 1\n", "where the one before it is");
    expect_refusal("# nothing\n", "no two points");
}

/// The veins that ship lie in the liver that ships, and no two of their points are in one place.
TEST(LiverVeins, AreInTheLiverAndReadable) {
    const auto tree = meshes::liver_veins();
    const auto file = std::filesystem::path(testing::TempDir()) / "veins.swc";
    std::ofstream(file) << meshes::swc_text(tree, "veins");
    EXPECT_EQ(meshes::read_swc(file, 1.0).segments, tree.segments);
    std::size_t outside = 0;
    for (const auto &point : tree.points)
        outside += meshes::liver_level(point) > 0.0 ? 1U : 0U;
    EXPECT_LE(outside, 4U) << "trunks alone reach the surface";
    EXPECT_NEAR(tree.radius.front(), 5.3e-3, 0.1e-3);
}

} // namespace livermark
