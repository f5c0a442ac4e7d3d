#include "meshes/segmentation/images/centrelines.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <span>
#include <vector>

#include "meshes/generators/liver_vessels.hpp"
#include "meshes/io/vessel_files.hpp"

namespace livermark::segmentation {
namespace {

using core::Vector3;

/// A straight tube with round ends.
struct Tube {
    Vector3 begin, end; ///< of its axis [m]
    double radius;      ///< [m]
};

double distance_to_line(const Vector3 &point, const Vector3 &begin, const Vector3 &end) {
    const Vector3 axis = end - begin, to_point = point - begin;
    return (to_point - std::clamp(to_point.dot(axis) / axis.squaredNorm(), 0.0, 1.0) * axis).norm();
}

bool holds(std::span<const Tube> tubes, const Vector3 &point) {
    return std::ranges::any_of(
        tubes, [&](const Tube &tube) { return distance_to_line(point, tube.begin, tube.end) < tube.radius; });
}

/// A grid of turned axes around the origin, 110 x 90 x 60 mm.
ImageGrid grid_of(const Vector3 &spacing) {
    ImageGrid grid{.spacing = spacing};
    const Vector3 size(0.11, 0.09, 0.06);
    for (Eigen::Index d = 0; d < 3; ++d)
        grid.size.at(static_cast<std::size_t>(d)) = 1 + static_cast<int>(size[d] / spacing[d]);
    grid.direction = Eigen::AngleAxisd(0.2, Vector3(1.0, 2.0, -1.0).normalized()).toRotationMatrix();
    grid.origin = -0.5 * grid.direction * size;
    return grid;
}

std::vector<char> voxels_where(const ImageGrid &grid, const std::function<bool(const Vector3 &)> &is_inside) {
    std::vector<char> voxels;
    for (int k = 0; k < grid.size[2]; ++k)
        for (int j = 0; j < grid.size[1]; ++j)
            for (int i = 0; i < grid.size[0]; ++i)
                voxels.push_back(is_inside(to_world(grid, Vector3(i, j, k).cwiseProduct(grid.spacing))) ? 1 : 0);
    return voxels;
}

core::VesselTree lines_in(std::span<const Tube> tubes, const ImageGrid &grid, const CentrelineOptions &options = {}) {
    return centrelines(grid, voxels_where(grid, [&](const Vector3 &point) { return holds(tubes, point); }), options);
}

/// Number of points where so many segments meet.
int num_points_of(const core::VesselTree &tree, int num_segments) {
    std::vector<int> at(tree.points.size(), 0);
    for (const auto &segment : tree.segments)
        for (const int point : segment)
            ++at[static_cast<std::size_t>(point)];
    return static_cast<int>(std::ranges::count(at, num_segments));
}

double distance_to(const core::VesselTree &tree, const Vector3 &point) {
    double distance = std::numeric_limits<double>::infinity();
    for (const auto &[a, b] : tree.segments)
        distance = std::min(distance, distance_to_line(point, tree.points[static_cast<std::size_t>(a)],
                                                       tree.points[static_cast<std::size_t>(b)]));
    return distance;
}

void expect_along(const core::VesselTree &tree, const Tube &tube, double tolerance) {
    for (int part = 0; part <= 40; ++part)
        EXPECT_LT(distance_to(tree, tube.begin + part / 40.0 * (tube.end - tube.begin)), tolerance) << part;
}

/// Each point ends one segment at most, as files of trees need it.
void expect_directed(const core::VesselTree &tree) {
    std::vector<int> ends(tree.points.size(), 0);
    for (const auto &segment : tree.segments)
        EXPECT_LE(++ends[static_cast<std::size_t>(segment[1])], 1);
}

const std::vector<Tube> fork{{{-0.04, 0.0, 0.0}, {0.0, 0.0, 0.0}, 0.005},
                             {{0.0, 0.0, 0.0}, {0.03, 0.028, 0.004}, 0.004},
                             {{0.0, 0.0, 0.0}, {0.032, -0.02, -0.008}, 0.003}};

TEST(Centrelines, OfAStraightTubeHaveItsLengthRadiusAndDirection) {
    for (const Vector3 &spacing : {Vector3(0.8e-3, 0.8e-3, 3e-3), Vector3(1.6e-3, 0.7e-3, 1.1e-3)})
        for (const double radius : {0.003, 0.0045}) {
            const Tube tube{{-0.03, -0.02, -0.01}, {0.03, 0.02, 0.012}, radius};
            const auto tree = lines_in(std::span(&tube, 1), grid_of(spacing));
            ASSERT_EQ(num_points_of(tree, 1), 2);
            EXPECT_EQ(tree.segments.size() + 1, tree.points.size());
            EXPECT_NEAR(meshes::length_of(tree) / ((tube.end - tube.begin).norm() + 2.0 * radius), 1.0, 0.05);
            for (const double r : tree.radius)
                EXPECT_NEAR(r / radius, 1.0, 0.1);
            const Vector3 along = (tree.points[tree.points.size() - 2] - tree.points[1]).normalized();
            EXPECT_GT(std::abs(along.dot((tube.end - tube.begin).normalized())), 0.999);
            expect_along(tree, tube, 0.6e-3);
            for (std::size_t s = 0; s < tree.segments.size(); ++s)
                EXPECT_NEAR(tree.length(s), CentrelineOptions{}.spacing, 0.5e-3);
        }
}

TEST(Centrelines, OfAForkMeetInOnePoint) {
    const auto tree = lines_in(fork, grid_of({0.8e-3, 0.9e-3, 1.5e-3}));
    EXPECT_EQ(num_points_of(tree, 1), 3);
    EXPECT_EQ(num_points_of(tree, 3), 1);
    EXPECT_EQ(tree.segments.size() + 1, tree.points.size());
    expect_directed(tree);
    double length = 0.0;
    for (const auto &tube : fork) {
        length += (tube.end - tube.begin).norm() + tube.radius;
        expect_along(tree, tube, 1e-3);
    }
    EXPECT_NEAR(meshes::length_of(tree) / length, 1.0, 0.05);
    EXPECT_LT((tree.points.front() - fork[0].begin).norm(), 0.008) << "the root is at the thick end";
}

TEST(Centrelines, LeaveOutWhatIsThick) {
    const auto tree = lines_in(fork, grid_of({0.8e-3, 0.9e-3, 1.5e-3}), {.largest_radius = 0.0044});
    EXPECT_EQ(num_points_of(tree, 1), 4) << "two lines";
    EXPECT_EQ(num_points_of(tree, 3), 0);
    for (const double radius : tree.radius)
        EXPECT_LE(radius, 0.0044);
    for (const auto &point : tree.points)
        EXPECT_GT(point.x(), -0.002) << "nothing in the trunk";
    EXPECT_TRUE(lines_in(fork, grid_of({0.8e-3, 0.9e-3, 1.5e-3}), {.largest_radius = 0.001}).points.empty());
}

TEST(Centrelines, OfATubeThatEndsInABallHaveNoSpurs) {
    const std::vector<Tube> tubes{{{-0.03, 0.0, 0.0}, {0.02, 0.01, 0.0}, 0.003},
                                  {{0.02, 0.01, 0.0}, {0.0201, 0.01, 0.0}, 0.008}};
    const auto tree = lines_in(tubes, grid_of({1e-3, 1e-3, 1e-3}));
    EXPECT_EQ(num_points_of(tree, 1), 2);
    EXPECT_EQ(num_points_of(tree, 3), 0);
    expect_along(tree, tubes[0], 1e-3);
}

TEST(Centrelines, OfPiecesAreTreesOfTheirOwnUnlessTheyAreShort) {
    const std::vector<Tube> tubes{{{-0.03, -0.02, 0.0}, {0.03, -0.02, 0.0}, 0.003},
                                  {{-0.03, 0.02, 0.0}, {0.03, 0.02, 0.0}, 0.003},
                                  {{0.0, 0.0, 0.0}, {0.001, 0.0, 0.0}, 0.003}};
    EXPECT_EQ(num_points_of(lines_in(tubes, grid_of({1e-3, 1e-3, 1e-3})), 1), 4);
}

TEST(Centrelines, OfNothingAreNone) {
    const auto grid = grid_of({2e-3, 2e-3, 2e-3});
    const auto tree = centrelines(grid, std::vector<char>(num_voxels(grid), 0), {});
    EXPECT_TRUE(tree.points.empty());
    EXPECT_TRUE(tree.segments.empty());
}

TEST(Centrelines, AreTheSameEveryTime) {
    const auto grid = grid_of({0.8e-3, 0.9e-3, 1.5e-3});
    EXPECT_EQ(lines_in(fork, grid), lines_in(fork, grid));
}

/// The label at a place that is in the image.
int label_at(const LabelImage &image, const Vector3 &point) {
    const Vector3 at =
        (image.grid.direction.transpose() * (point - image.grid.origin)).cwiseQuotient(image.grid.spacing);
    const auto voxel = [&](Eigen::Index d) { return static_cast<std::size_t>(std::lround(at[d])); };
    const auto row = static_cast<std::size_t>(image.grid.size[0]),
               column = static_cast<std::size_t>(image.grid.size[1]);
    return image.label[voxel(0) + row * (voxel(1) + column * voxel(2))];
}

/// Whether a trunk is whole at a place of its axis: near the border of the liver and in lesions it is not.
bool is_whole_at(const LabelImage &image, int label, const Vector3 &place, double radius) {
    for (Eigen::Index d = 0; d < 3; ++d)
        for (const double side : {-0.8, 0.8})
            if (label_at(image, place + side * radius * Vector3::Unit(d)) != label)
                return false;
    return label_at(image, place) == label;
}

TEST(Centrelines, OfThePhantomFollowItsTrunks) {
    const auto image = phantom_labels({.vessels = true});
    for (const auto vein : {meshes::LiverVein::hepatic, meshes::LiverVein::portal}) {
        const int label = vein == meshes::LiverVein::hepatic ? phantom_hepatic_label : phantom_portal_label;
        std::vector<char> is_vessel;
        for (const int each : image.label)
            is_vessel.push_back(each == label ? 1 : 0);
        const auto tree = centrelines(image.grid, is_vessel, {});
        EXPECT_EQ(num_points_of(tree, 1), 3) << "a trunk and two branches";
        EXPECT_EQ(num_points_of(tree, 3), 1);
        expect_directed(tree);
        for (const double radius : tree.radius) {
            EXPECT_GT(radius, 0.95 * 0.003);
            EXPECT_LT(radius, 1.05 * 0.006);
        }
        for (const auto &trunk : meshes::liver_vein_trunks())
            for (int part = 0; trunk.vein == vein && part <= 40; ++part)
                if (const Vector3 place = trunk.begin + part / 40.0 * (trunk.end - trunk.begin);
                    is_whole_at(image, label, place, trunk.radius)) {
                    EXPECT_LT(distance_to(tree, place), 1.5e-3) << place.transpose();
                }
    }
}

} // namespace
} // namespace livermark::segmentation
