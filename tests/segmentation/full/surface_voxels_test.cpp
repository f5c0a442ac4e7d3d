#include "segmentation/surfaces/surface_voxels.hpp"

#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "meshes/generators/surface_mesh.hpp"
#include "support/input_error.hpp"

namespace livermark::segmentation {
namespace {

meshes::SurfaceMesh ball(double radius, const core::Vector3 &centre = {0.0, 0.0, 0.0}) {
    auto surface = meshes::geodesic_sphere(12);
    for (auto &point : surface.points)
        point = centre + radius * point;
    return surface;
}

TEST(VoxelsWithin, HaveTheVolumesOfTheSurfaces) {
    const auto liver = ball(0.05);
    const auto lesion = ball(0.012, {0.04, 0.0, 0.0}); // reaches out of it
    const auto voxels = voxels_within({liver, lesion}, 0.8e-3);
    const auto volumes = region_volumes(voxels);
    ASSERT_EQ(voxels.region_names, (std::vector<std::string>{"parenchyma", "tumour_1"}));
    EXPECT_NEAR((volumes[0] + volumes[1]) / meshes::enclosed_volume(liver), 1.0, 2e-3);
    EXPECT_LT(volumes[1], meshes::enclosed_volume(lesion));
    EXPECT_GT(volumes[1], 0.6 * meshes::enclosed_volume(lesion));
    ASSERT_EQ(voxels.remarks.size(), 1U);
    EXPECT_NE(voxels.remarks[0].find("are outside the liver and are left out"), std::string::npos) << voxels.remarks[0];
    EXPECT_TRUE(voxels_within({liver, ball(0.012)}, 0.8e-3).remarks.empty()) << "all of it is inside";
}

TEST(VoxelsWithin, RefuseALesionElsewhere) {
    EXPECT_THROW(voxels_within({ball(0.05), ball(0.01, {0.2, 0.0, 0.0})}, 2e-3), support::InputError);
}

/// A part of it is beyond the box around the liver, where no voxels are.
TEST(VoxelsWithin, CutALesionAtTheLiverWhereverItReachesOut) {
    const auto liver = ball(0.05);
    const double spacing = 1.5e-3;
    const auto one = voxels_within({liver, ball(0.03, {0.0, 0.0, 0.05})}, spacing); // rows start beside it
    ASSERT_EQ(one.remarks.size(), 1U);
    const double expected = region_volumes(one)[1];
    for (const core::Vector3 &centre :
         {core::Vector3{0.05, 0.0, 0.0}, core::Vector3{-0.05, 0.0, 0.0}, core::Vector3{0.0, -0.05, 0.0}}) {
        SCOPED_TRACE(centre.transpose());
        const auto other = voxels_within({liver, ball(0.03, centre)}, spacing);
        EXPECT_NEAR(region_volumes(other)[1] / expected, 1.0, 0.02);
        ASSERT_EQ(other.remarks.size(), 1U);
        EXPECT_NE(other.remarks[0].find("are outside the liver"), std::string::npos) << other.remarks[0];
    }
}

TEST(VoxelsWithin, GiveWhatTwoLesionsShareToTheSmallerAndSaySo) {
    const auto liver = ball(0.05), large = ball(0.02), small = ball(0.012, {0.02, 0.0, 0.0});
    const auto first = voxels_within({liver, large, small}, 1e-3), second = voxels_within({liver, small, large}, 1e-3);
    EXPECT_NEAR(region_volumes(first)[2] / meshes::enclosed_volume(small), 1.0, 0.02);
    EXPECT_EQ(region_volumes(first)[2], region_volumes(second)[1]) << "whatever their order";
    ASSERT_EQ(first.remarks.size(), 1U);
    EXPECT_NE(first.remarks[0].find("tumour_1 and tumour_2 share"), std::string::npos) << first.remarks[0];
    EXPECT_NE(first.remarks[0].find("count as tumour_2, the smaller one"), std::string::npos) << first.remarks[0];
    EXPECT_TRUE(
        voxels_within({liver, ball(0.01, {0.02, 0.0, 0.0}), ball(0.01, {-0.02, 0.0, 0.0})}, 1e-3).remarks.empty());
}

TEST(VoxelsWithin, RefuseALesionOfWhichNothingIsLeft) {
    const auto liver = ball(0.05), lesion = ball(0.01);
    EXPECT_THROW(voxels_within({liver, lesion, lesion}, 2e-3), support::InputError);
    EXPECT_THROW(voxels_within({liver, liver}, 2e-3), support::InputError) << "nor of the liver";
}

} // namespace
} // namespace livermark::segmentation
