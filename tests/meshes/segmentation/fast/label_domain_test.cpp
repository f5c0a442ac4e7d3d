#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numeric>

#include "meshes/segmentation/meshing/mesh_operations.hpp"
#include "tests/same_bits.hpp"

namespace livermark::segmentation {
namespace {

using core::Vector3;

/// @param region_at  0 outside, else 1 + region, of a place in the image [m]
Segmentation voxels(const std::array<int, 3> &size, const Vector3 &spacing, int num_regions,
                    const std::function<int(const Vector3 &)> &region_at) {
    Segmentation segmentation;
    segmentation.grid.size = size;
    segmentation.grid.spacing = spacing;
    for (int k = 0; k < size[2]; ++k)
        for (int j = 0; j < size[1]; ++j)
            for (int i = 0; i < size[0]; ++i)
                segmentation.region.push_back(
                    static_cast<std::uint8_t>(region_at(spacing.cwiseProduct(Vector3(i, j, k)))));
    for (int r = 0; r < num_regions; ++r)
        segmentation.region_names.push_back("region " + std::to_string(r));
    return segmentation;
}

/// A ball of 20 mm with one of 8 mm in it, in slices of 3 mm.
Segmentation ball_in_ball() {
    const Vector3 center(0.022, 0.022, 0.0225);
    return voxels({45, 45, 16}, {0.001, 0.001, 0.003}, 2, [&](const Vector3 &place) {
        if ((place - center).norm() > 0.020)
            return 0;
        return (place - center - Vector3(0.004, 0.0, 0.0)).norm() > 0.008 ? 1 : 2;
    });
}

std::size_t sample_at(const LabelFields &fields, const Vector3 &place) {
    std::array<std::size_t, 3> index{};
    for (int d = 0; d < 3; ++d)
        index[d] = static_cast<std::size_t>(std::lround((place[d] - fields.low[d]) / fields.spacing));
    return index[0] + fields.size[0] * (index[1] + fields.size[1] * index[2]);
}

TEST(LabelFields, AreOneWellInsideTheRegionAndZeroWellOutside) {
    const auto fields = label_fields(ball_in_ball(), 0.0012);
    const std::size_t in_lesion = sample_at(fields, {0.026, 0.022, 0.0225});
    const std::size_t in_rest = sample_at(fields, {0.010, 0.022, 0.0225});
    const std::size_t in_neither = sample_at(fields, {0.0, 0.0, 0.0});
    EXPECT_NEAR(fields.inside[0][in_lesion], 0.0, 0.01);
    EXPECT_NEAR(fields.inside[1][in_lesion], 1.0, 0.01);
    EXPECT_NEAR(fields.inside[0][in_rest], 1.0, 0.01);
    EXPECT_NEAR(fields.inside[1][in_rest], 0.0, 0.01);
    EXPECT_NEAR(fields.inside[0][in_neither], 0.0, 0.01);
    EXPECT_NEAR(fields.inside[1][in_neither], 0.0, 0.01);
}

TEST(LabelFields, WantTheVolumesOfTheVoxels) {
    const auto segmentation = ball_in_ball();
    EXPECT_EQ(label_fields(segmentation, 0.0012).volume, region_volumes(segmentation));
}

TEST(LabelFields, ConserveTheVolumeOfEveryRegion) {
    const auto fields = label_fields(ball_in_ball(), 0.0012);
    for (std::size_t r = 0; r < 2; ++r) {
        const double sum = std::accumulate(fields.inside[r].begin(), fields.inside[r].end(), 0.0);
        EXPECT_NEAR(sum * std::pow(0.0012, 3), fields.volume[r], 1e-3 * fields.volume[r]);
    }
}

TEST(LabelFields, ConserveTheVolumeOfABodyThatTheImageCutsOff) {
    const auto fields =
        label_fields(voxels({12, 12, 6}, {0.001, 0.001, 0.003}, 1, [](const Vector3 &) { return 1; }), 0.001);
    const double sum = std::accumulate(fields.inside[0].begin(), fields.inside[0].end(), 0.0);
    EXPECT_NEAR(sum * 1e-9, fields.volume[0], 1e-3 * fields.volume[0]);
}

TEST(LabelFields, VanishOnTheBorderOfTheirGrid) {
    const auto fields =
        label_fields(voxels({12, 12, 6}, {0.001, 0.001, 0.003}, 1, [](const Vector3 &) { return 1; }), 0.001);
    std::size_t sample = 0;
    ASSERT_GE(std::ranges::min(fields.size), 6);
    for (int k = 0; k < fields.size[2]; ++k)
        for (int j = 0; j < fields.size[1]; ++j)
            for (int i = 0; i < fields.size[0]; ++i, ++sample)
                if (i == 0 || j == 0 || k == 0 || i == fields.size[0] - 1 || j == fields.size[1] - 1 ||
                    k == fields.size[2] - 1) {
                    ASSERT_EQ(fields.inside[0][sample], 0.0F);
                }
}

TEST(LabelFields, HaveASlantedWallWithoutTheStairsOfItsSlices) {
    // The stairs of the voxels are 3 mm high and 6 mm long.
    const auto height = [](double x) { return 0.008 + 0.5 * x; };
    const auto fields =
        label_fields(voxels({60, 12, 16}, {0.001, 0.001, 0.003}, 1,
                            [&](const Vector3 &place) { return place.z() < height(place.x()) ? 1 : 0; }),
                     0.001);
    double farthest = 0.0;
    for (double x = 0.015; x < 0.045; x += 0.001) {
        const std::size_t foot = sample_at(fields, {x, 0.006, 0.0});
        const std::size_t slice = std::size_t(fields.size[0]) * fields.size[1];
        const double column = fields.low.x() + fields.spacing * static_cast<double>(foot % fields.size[0]);
        const double start = fields.low.z() + fields.spacing * static_cast<double>(foot / slice);
        std::size_t steps = 3; // from well inside, whatever the end of the image does
        while (fields.inside[0][foot + (steps + 1) * slice] > 0.5F)
            ++steps;
        const double here = fields.inside[0][foot + steps * slice];
        const double next = fields.inside[0][foot + (steps + 1) * slice];
        const double wall = start + fields.spacing * (static_cast<double>(steps) + (here - 0.5) / (here - next));
        farthest = std::max(farthest, std::abs(wall - height(column)));
    }
    EXPECT_LT(farthest, 0.0006); // 1.5 mm in the voxels
}

TEST(LabelFields, AreTheSameBitsEveryTime) {
    const auto first = label_fields(ball_in_ball(), 0.0012);
    const auto second = label_fields(ball_in_ball(), 0.0012);
    for (std::size_t r = 0; r < 2; ++r)
        EXPECT_TRUE(tests::same_bits(first.inside[r], second.inside[r]));
}

} // namespace
} // namespace livermark::segmentation
