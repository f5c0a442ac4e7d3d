#include "core/mesh/interior_place.hpp"

#include <gtest/gtest.h>
#include <numeric>
#include <stdexcept>

#include "tests/samples/test_meshes.hpp"

namespace livermark::core {
namespace {

constexpr double radius = 0.01;

TetraMesh block(int bricks) {
    return tests::box_mesh({0.06, 0.05, 0.04}, {bricks, bricks, bricks});
}

/// The mean of a linear field over a place.
double mean_of(const TetraMesh &mesh, const InteriorPlace &place, const Vector3 &slope) {
    double mean = 0.0;
    for (const auto &[tetrahedron, barycentric, weight] : points_of(place, mesh))
        for (int i = 0; i < 4; ++i)
            mean += weight * barycentric[i] * slope.dot(mesh.points[mesh.tetrahedra[tetrahedron][i]]);
    return mean;
}

TEST(InteriorPlace, HasTheMeanOfALinearFieldInItsMiddle) {
    const InteriorPlace place{{0.031, 0.022, 0.018}, radius};
    for (const int bricks : {1, 3, 7})
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(mean_of(block(bricks), place, Vector3::Unit(axis)), place.middle[axis], 1e-4 * radius)
                << bricks << " bricks";
}

TEST(InteriorPlace, EndsWhereTheBodyEnds) {
    const InteriorPlace place{{0.03, 0.025, 0.0}, radius};
    // Of half a ball, whose weight (1 - r^2)^2 has its centroid 35/128 of the radius inside.
    EXPECT_NEAR(mean_of(block(4), place, Vector3::UnitZ()), 35.0 / 128.0 * radius, 2e-3 * radius);
    EXPECT_THROW(points_of({{0.03, 0.025, -0.02}, radius}, block(4)), std::invalid_argument);
}

TEST(InteriorPlace, GivesNodesAllOfAForce) {
    const auto mesh = block(3);
    const std::vector<InteriorPlace> places{{{0.031, 0.022, 0.018}, radius}, {{0.01, 0.01, 0.039}, 0.4 * radius}};
    const auto weights = nodal_weights(places, mesh);
    ASSERT_EQ(weights.rows(), 2);
    ASSERT_EQ(weights.cols(), mesh.num_nodes());
    for (int place = 0; place < 2; ++place)
        EXPECT_NEAR(weights.row(place).sum(), 1.0, 1e-12);
}

} // namespace
} // namespace livermark::core
