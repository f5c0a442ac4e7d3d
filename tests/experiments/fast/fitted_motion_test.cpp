#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "experiments/fitted_motion.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::experiments {
namespace {

using core::Vector3;

/// 7 x 7 points in a tilted plane.
std::vector<Vector3> layer() {
    std::vector<Vector3> points;
    for (int i = 0; i < 7; ++i)
        for (int j = 0; j < 7; ++j)
            points.emplace_back(0.01 * i, 0.012 * j, 0.05 + 0.002 * i);
    return points;
}

Vector3 bent(const Vector3 &x) {
    return {0.001 + 0.02 * x.x(), 0.3 * x.x() * x.y(), -0.004 - 2.0 * x.x() * x.x() + x.y() * x.y()};
}

std::vector<Vector3> moved(const std::vector<Vector3> &points, Vector3 (*motion)(const Vector3 &)) {
    std::vector<Vector3> result;
    for (const auto &point : points)
        result.push_back(motion(point));
    return result;
}

TEST(FittedMotion, IsExactForPolynomialsOfItsDegree) {
    const auto points = layer();
    const auto displacements = moved(points, bent);
    const FittedMotion quadratic(points, displacements, 2, "top"), linear(points, displacements, 1, "top");
    EXPECT_LT(quadratic.residual(), 1e-15);
    EXPECT_GT(linear.residual(), 1e-4);
    const Vector3 between(0.033, 0.041, 0.05 + 0.2 * 0.033);
    EXPECT_LT((quadratic.at(between) - bent(between)).norm(), 1e-15);
}

TEST(FittedMotion, SmoothsNoise) {
    const auto points = layer();
    auto displacements = moved(points, bent);
    for (std::size_t k = 0; k < displacements.size(); ++k)
        displacements[k].z() += k % 2 == 0 ? 1e-4 : -1e-4;
    const FittedMotion motion(points, displacements, 2, "top");
    EXPECT_NEAR(motion.residual(), 1e-4, 1e-5);
    for (const auto &point : points)
        EXPECT_LT((motion.at(point) - bent(point)).norm(), 3e-5);
}

TEST(FittedMotion, OfMarkersThatDoNotDetermineItIsRefused) {
    const auto points = layer();
    const std::vector<Vector3> five(points.begin(), points.begin() + 5), none(5, Vector3::Zero());
    tests::expect_input_error([&] { FittedMotion(five, none, 2, "jelly: place top"); },
                              {"jelly: place top", "5 markers", "6 coefficients"});
    std::vector<Vector3> line;
    for (int k = 0; k < 10; ++k)
        line.emplace_back(0.01 * k, 0.0, 0.0);
    tests::expect_input_error([&] { FittedMotion(line, std::vector<Vector3>(10, Vector3::Zero()), 1, "top"); },
                              {"top", "do not determine"});
}

TEST(FittedMotion, MovesTheNodesOfItsPatchAlone) {
    const auto mesh = tests::box_mesh({0.06, 0.08, 0.05}, {2, 2, 2});
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "z_max", Vector3::Zero());
    const auto points = layer();
    const FittedMotion motion(points, moved(points, bent), 2, "top");
    drive(load_case, mesh, {"z_max", motion});
    for (int node = 0; node < mesh.num_nodes(); ++node) {
        const auto &x = mesh.points[node];
        EXPECT_EQ(load_case.node_shift[node], x.z() > 0.05 - 1e-9 ? motion.at(x) : Vector3(Vector3::Zero()));
    }
    EXPECT_TRUE(core::is_driven(load_case));
    tests::expect_input_error([&] { drive(load_case, mesh, {"lid", motion}); }, {"'lid'", "z_max"});
    tests::expect_input_error([&] { drive(load_case, mesh, {"x_max", motion}); }, {"'x_max'", "nothing constrains it"});
}

TEST(StraightLine, IsExactForAffineMotion) {
    const auto stretched = [](const Vector3 &x) { return Vector3(0.1 * x.z(), -0.02 * x.y(), 0.3 * x.z()); };
    std::vector<Vector3> low, high, low_moved, high_moved;
    for (auto point : layer()) {
        point.z() = 0.0;
        low.push_back(point);
        low_moved.push_back(stretched(point));
        point.z() = 0.1;
        high.push_back(point);
        high_moved.push_back(stretched(point));
    }
    const PlaceMotion from{"z_min", FittedMotion(low, low_moved, 1, "low")},
        to{"z_max", FittedMotion(high, high_moved, 1, "high")};
    const Vector3 point(0.02, 0.03, 0.07);
    EXPECT_LT((straight_line(from, to, point) - stretched(point)).norm(), 1e-15);
}

TEST(BestRigidMotion, FindsALargeRotation) {
    const Eigen::Matrix3d rotation = Eigen::AngleAxisd(2.5, Vector3(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
    const auto points = layer();
    std::vector<Vector3> targets;
    for (const auto &point : points)
        targets.emplace_back(rotation * point + Vector3(0.1, 0.0, -0.2));
    const auto found = best_rigid_motion(points, targets);
    EXPECT_LT((found.rotation - rotation).norm(), 1e-14);
    for (std::size_t k = 0; k < points.size(); ++k)
        EXPECT_LT((found.at(points[k]) - targets[k]).norm(), 1e-14);
}

/// A reflection would fit better, and no body does that.
TEST(BestRigidMotion, IsNoReflection) {
    const std::vector<Vector3> points{{1, 0, 0}, {0, 1, 0}, {0, 0, 0.1}, {-1, -1, -0.1}};
    std::vector<Vector3> targets;
    for (const auto &point : points)
        targets.emplace_back(point.x(), point.y(), -point.z());
    EXPECT_NEAR(best_rigid_motion(points, targets).rotation.determinant(), 1.0, 1e-12);
}

} // namespace
} // namespace livermark::experiments
