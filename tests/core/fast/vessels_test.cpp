#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/mesh/places.hpp"
#include "core/mesh/refinement.hpp"
#include "core/part_springs.hpp"
#include "tests/samples/bodies_with_vessels.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;
namespace vessels = tests::vessels;

const core::Material soft{1060.0, 5000.0, 0.45};
const Vector3 sides{0.1, 0.1, 0.1};

std::shared_ptr<const core::Body> block() {
    return vessels::with_vessels(tests::make_body(tests::box_mesh(sides, {4, 4, 4}), soft));
}

double whole_weight(const core::Body &body) {
    double sum = 0.0;
    for (const auto &point : core::vessel_points(body))
        sum += point.weight;
    return sum;
}

} // namespace

TEST(VesselTree, HasTheStiffnessOfItsWallLessThatOfTheTissue) {
    const auto stiffness = vessels::tree.axial_stiffness(1, 5000.0);
    EXPECT_NEAR(stiffness, std::numbers::pi * 9e-6 * (1e6 * (1.0 - 0.64) - 5000.0), 1e-12);
    EXPECT_EQ(vessels::tree.axial_stiffness(1, 1e6), 0.0) << "no less than nothing";
}

TEST(VesselPoints, LieOnTheLinesAndHaveAllOfTheirLength) {
    const auto body = block();
    const auto &tree = *body->vessels;
    double expected = 0.0, whole = 0.0, inside = 0.0;
    for (std::size_t s = 0; s < tree.segments.size(); ++s) {
        const double length = vessels::length_inside(tree, s, sides);
        expected += length * tree.axial_stiffness(s, soft.young_modulus);
        whole += tree.length(s);
        inside += length;
    }
    // The surface cuts fibres of a line that is oblique at other places than its axis.
    EXPECT_NEAR(whole_weight(*body), expected, 1e-3 * expected);
    EXPECT_NEAR(core::part_inside(*body), inside / whole, 1e-3);
    EXPECT_LT(core::part_inside(*body), 0.85);
    for (const auto &point : core::vessel_points(*body)) {
        EXPECT_GT(point.coordinates.minCoeff(), 0.0);
        EXPECT_NEAR(point.coordinates.sum(), 1.0, 1e-12);
        EXPECT_NEAR(point.direction.norm(), 1.0, 1e-12);
        Vector3 place = Vector3::Zero();
        for (int k = 0; k < 4; ++k)
            place += point.coordinates[k] * body->mesh.points[body->mesh.tetrahedra[point.tetrahedron][k]];
        double nearest = 1.0;
        for (const auto &[a, b] : tree.segments) {
            const Vector3 begin = tree.points[a], way = tree.points[b] - begin;
            const double along = std::clamp((place - begin).dot(way) / way.squaredNorm(), 0.0, 1.0);
            nearest = std::min(nearest, (place - begin - along * way).norm());
        }
        EXPECT_LT(nearest, 4e-3 + 1e-6);
        EXPECT_GT(nearest, 1e-3);
    }
}

/// Springs have the energy of the lines where F is the same everywhere, however large it is.
TEST(VesselSprings, HaveTheEnergyOfTheFibres) {
    const auto body = block();
    Eigen::Matrix3d f;
    f << 1.3, 0.2, -0.1, 0.0, 0.8, 0.3, 0.1, -0.2, 1.1;
    double fibres = 0.0, springs = 0.0;
    for (const auto &point : core::vessel_points(*body))
        fibres += point.energy(f * point.direction);
    for (const auto &spring : core::vessel_springs(*body)) {
        const Vector3 span = core::point_in(*body, spring.tetrahedron, spring.ends[1]) -
                             core::point_in(*body, spring.tetrahedron, spring.ends[0]);
        EXPECT_NEAR(span.norm(), spring.rest_length, 1e-15);
        const double longer = (f * span).norm() - spring.rest_length;
        springs += 0.5 * spring.stiffness * longer * longer;
    }
    EXPECT_GT(fibres, 0.0);
    EXPECT_NEAR(springs, fibres, 1e-9 * fibres);
}

TEST(VesselSprings, AreNotWhereTissueIsAsStiffAsTheWall) {
    const auto soft_wall = vessels::rod({0.01, 0.05, 0.05}, {0.09, 0.05, 0.05}, 1e-3, 4000.0);
    const auto body = vessels::with_vessels(tests::make_body(tests::box_mesh(sides, {4, 4, 4}), soft), soft_wall);
    EXPECT_FALSE(core::vessel_points(*body).empty());
    EXPECT_TRUE(core::vessel_springs(*body).empty());
}

/// Edges that four, six or more tetrahedra share have their length once.
TEST(VesselPoints, OfALineAlongEdgesCountOnce) {
    for (const double height : {0.05, 0.06}) {
        const auto rod = vessels::rod({0.0, 0.05, height}, {0.1, 0.05, height}, 1e-8, 1e6); // all fibres in the edges
        const auto body = vessels::with_vessels(tests::make_body(tests::box_mesh(sides, {4, 4, 4}), soft), rod);
        EXPECT_NEAR(whole_weight(*body), 0.1 * rod.axial_stiffness(0, 5000.0), 2e-6 * whole_weight(*body));
    }
}

TEST(VesselPoints, AreThoseOfTheSameLinesOnARefinedMesh) {
    const auto body = block();
    const auto refined = core::refine(*body);
    ASSERT_TRUE(refined.vessels);
    EXPECT_NEAR(whole_weight(refined), whole_weight(*body), 1e-9 * whole_weight(*body));
    EXPECT_TRUE(core::vessel_points(*tests::make_body(body->mesh, soft)).empty());
}

TEST(VesselPoint, HasTheDerivativesOfItsEnergy) {
    const core::VesselPoint point{0, Eigen::Vector4d::Zero(), Vector3::UnitX(), 3.0};
    for (const Vector3 &moved : {Vector3(1.2, 0.3, -0.2), Vector3(0.7, 0.1, 0.2)}) {
        constexpr double step = 1e-6;
        for (int k = 0; k < 3; ++k) {
            const Vector3 way = step * Vector3::Unit(k);
            EXPECT_NEAR((point.energy(moved + way) - point.energy(moved - way)) / (2.0 * step), point.pull(moved)[k],
                        1e-8);
            const Vector3 slope = (point.pull(moved + way) - point.pull(moved - way)) / (2.0 * step);
            EXPECT_LT((slope - point.stiffness(moved).col(k)).norm(), 1e-8);
        }
    }
}

} // namespace livermark
