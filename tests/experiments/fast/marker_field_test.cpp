#include <algorithm>
#include <gtest/gtest.h>

#include "experiments/marker_field.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::experiments {
namespace {

using core::Vector3;

std::vector<Vector3> at_nodes(const core::TetraMesh &mesh, Vector3 (*field)(const Vector3 &)) {
    std::vector<Vector3> values;
    for (const auto &point : mesh.points)
        values.push_back(field(point));
    return values;
}

Vector3 affine(const Vector3 &x) {
    return {0.01 + 0.2 * x.y(), -0.1 * x.z(), 0.3 * x.x() + 0.1 * x.z()};
}

Vector3 bulge(const Vector3 &x) {
    return {4.0 * x.x() * x.z() * (0.1 - x.z()), 0.0, x.x() * x.x()};
}

TEST(MarkerField, IsExactForAffineDisplacementsInsideAndOnPegs) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {3, 3, 3});
    const std::vector<Vector3> points{
        {0.031, 0.047, 0.022}, {0.1, 0.1, 0.1}, {0.05, 0.04, 0.112}, {-0.01, -0.02, 0.05}};
    const MarkerField field(mesh, points);
    const auto found = field.at_points(at_nodes(mesh, affine));
    for (std::size_t k = 0; k < points.size(); ++k)
        EXPECT_LT((found[k] - affine(points[k])).norm(), 1e-15) << k;
    EXPECT_EQ(field.outside()[0], 0.0);
    EXPECT_NEAR(field.outside()[1], 0.0, 1e-12);
    EXPECT_NEAR(field.outside()[2], 0.012, 1e-12);
    EXPECT_NEAR(field.outside()[3], std::hypot(0.01, 0.02), 1e-12);
}

TEST(MarkerField, DependsOnItsNodesAlone) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {5, 5, 5});
    const std::vector<Vector3> points{{0.031, 0.047, 0.022}, {0.05, 0.04, 0.112}};
    const MarkerField field(mesh, points);
    const auto nodes = field.nodes();
    EXPECT_TRUE(std::ranges::is_sorted(nodes));
    EXPECT_LT(nodes.size(), mesh.points.size());
    const auto everywhere = at_nodes(mesh, bulge);
    std::vector<Vector3> there(mesh.points.size(), Vector3::Constant(1.0));
    for (const int node : nodes)
        there[node] = everywhere[node];
    EXPECT_EQ(field.at_points(there), field.at_points(everywhere));
}

/// Linear interpolation of the bulge is up to h^2 / 8 of its curvature off.
TEST(MarkerField, FollowsCurvatureBetweenNodes) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {5, 5, 5});
    std::vector<Vector3> points;
    for (int k = 0; k < 10; ++k)
        points.emplace_back(0.03 + 0.004 * k, 0.05, 0.07 - 0.0035 * k);
    const auto found = MarkerField(mesh, points).at_points(at_nodes(mesh, bulge));
    constexpr double linear_error = 0.02 * 0.02 / 8.0 * 2.0;
    for (std::size_t k = 0; k < points.size(); ++k)
        EXPECT_LT((found[k] - bulge(points[k])).norm(), 0.1 * linear_error) << k;
}

} // namespace
} // namespace livermark::experiments
