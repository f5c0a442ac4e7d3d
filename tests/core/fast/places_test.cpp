#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "core/error_norms.hpp"
#include "core/mesh/places.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

double power(double base, int exponent) {
    return exponent == 0 ? 1.0 : std::pow(base, exponent);
}

double factorial(int n) {
    return std::tgamma(n + 1.0);
}

/// The mean of a^i b^j c^k over a triangle is 2 i! j! k! / (i + j + k + 2)!.
TEST(FacetPoints, IntegratePolynomialsUpToTheFifthDegree) {
    for (const int divisions : {1, 2, 3, 5})
        for (int i = 0; i <= 5; ++i)
            for (int j = 0; i + j <= 5; ++j)
                for (int k = 0; i + j + k <= 5; ++k) {
                    double mean = 0.0;
                    for (const auto &point : core::facet_points(divisions))
                        mean +=
                            point.part * power(point.shape[0], i) * power(point.shape[1], j) * power(point.shape[2], k);
                    const double expected = 2.0 * factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 2);
                    EXPECT_NEAR(mean, expected, 1e-14);
                }
}

TEST(FacetPoints, LieInsideAndAreSevenInEachPart) {
    for (const int divisions : {1, 2, 4}) {
        const auto points = core::facet_points(divisions);
        EXPECT_EQ(points.size(), 7U * static_cast<std::size_t>(divisions * divisions));
        for (const auto &point : points) {
            EXPECT_GT(point.part, 0.0);
            for (const double shape : point.shape)
                EXPECT_GT(shape, 0.0);
        }
    }
}

} // namespace
} // namespace livermark

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

namespace livermark {
namespace {

using core::Vector3;

core::TetraMesh two_regions() {
    auto mesh = tests::box_mesh({0.1, 0.2, 0.1}, {2, 3, 2});
    mesh.region_names = {"parenchyma", "tumour"};
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        mesh.region[t] = t < 12 ? 1 : 0;
    return mesh;
}

std::vector<Vector3> mapped(const core::TetraMesh &mesh, const Eigen::Matrix3d &gradient, const Vector3 &shift) {
    std::vector<Vector3> displacement;
    for (const auto &point : mesh.points)
        displacement.emplace_back(gradient * point + shift - point);
    return displacement;
}

TEST(Deformation, OfAnAffineMapIsThatOfItsMatrix) {
    const auto mesh = two_regions();
    Eigen::Matrix3d gradient;
    gradient << 1.2, 0.3, 0.0, -0.1, 0.9, 0.2, 0.0, 0.1, 1.1;
    const Vector3 shift(0.01, -0.02, 0.03);
    const auto at_rest = core::deformation(mesh, std::vector<Vector3>(mesh.points.size(), Vector3::Zero()));
    const auto deformed = core::deformation(mesh, mapped(mesh, gradient, shift));
    EXPECT_NEAR(at_rest.volume_change, 0.0, 1e-14);
    EXPECT_NEAR(deformed.volume_change, gradient.determinant() - 1.0, 1e-12);
    EXPECT_NEAR(deformed.smallest_jacobian, gradient.determinant(), 1e-12);
    EXPECT_EQ(deformed.num_inverted, 0);
    for (std::size_t r = 0; r < 2; ++r)
        EXPECT_LT((deformed.centroid[r] - (gradient * at_rest.centroid[r] + shift)).norm(), 1e-14);
}

TEST(Deformation, CountsWhatIsInsideOut) {
    const auto mesh = two_regions();
    EXPECT_EQ(core::deformation(mesh, mapped(mesh, Vector3(1.0, 1.0, -0.5).asDiagonal(), Vector3::Zero())).num_inverted,
              mesh.num_tetrahedra());
    auto displacement = std::vector<Vector3>(mesh.points.size(), Vector3::Zero());
    displacement.front().x() = std::numeric_limits<double>::quiet_NaN();
    const auto lost = core::deformation(mesh, displacement);
    EXPECT_GT(lost.num_inverted, 0);
    EXPECT_TRUE(std::isnan(lost.smallest_jacobian));
    EXPECT_TRUE(std::isnan(lost.volume_change));
    displacement.pop_back();
    EXPECT_THROW(core::deformation(mesh, displacement), std::invalid_argument);
}

core::Solution along_a_path(const core::TetraMesh &mesh, double scale) {
    core::Solution solution;
    solution.displacement = mapped(mesh, (1.0 + 0.1 * scale) * Eigen::Matrix3d::Identity(), Vector3::Zero());
    solution.reaction = {{0.0, 0.0, 2.0 * scale}, {0.0, 0.0, -scale}};
    solution.strain_energy = 4.0;
    for (const double fraction : {0.5, 1.0}) {
        auto &point = solution.path.emplace_back();
        for (const auto &displacement : solution.displacement)
            point.displacement.push_back((fraction * displacement).cast<float>());
        for (const auto &reaction : solution.reaction)
            point.reaction.emplace_back(fraction * reaction);
    }
    return solution;
}

TEST(PathComparison, MeasuresUniformFactorsExactly) {
    const auto mesh = two_regions();
    const auto reference = along_a_path(mesh, 1.0);
    auto solution = along_a_path(mesh, 1.2);
    solution.path.front().reaction[1] *= 3.0;
    const auto path = core::compare(mesh, {}, solution, reference, "reference").path.value();
    EXPECT_NEAR(path.reaction_bias, 0.2, 1e-14);
    EXPECT_NEAR(path.worst_relative_l2, 0.2, 1e-6); // single precision
    EXPECT_NEAR(path.worst_reaction_error, std::sqrt((0.4 * 0.4 + 2.6 * 2.6) / 5.0), 1e-12);
    EXPECT_NEAR(path.volume_error, std::pow(1.12, 3) - std::pow(1.1, 3), 1e-12);
    const auto centroid = core::deformation(mesh, std::vector<Vector3>(mesh.points.size(), Vector3::Zero())).centroid;
    for (std::size_t r = 0; r < 2; ++r)
        EXPECT_NEAR(path.centroid_error[r], 0.02 * centroid[r].norm(), 1e-14);
    // Of errors that grow from one corner to the other 95 % are below what the corner has, and above the mean.
    const auto comparison = core::compare(mesh, {}, solution, reference, "reference");
    EXPECT_LT(path.percentile_95, comparison.max_error);
    EXPECT_GT(path.percentile_95, 0.5 * comparison.max_error);
}

TEST(PathComparison, IsNotThereWithoutAPathAndGoesAsFarAsTheSolution) {
    const auto mesh = two_regions();
    auto reference = along_a_path(mesh, 1.0);
    auto solution = along_a_path(mesh, 1.5);
    solution.path.pop_back();
    EXPECT_NEAR(core::compare(mesh, {}, solution, reference, "reference").path->worst_reaction_error, 0.5, 1e-12);
    reference.path.clear();
    EXPECT_FALSE(core::compare(mesh, {}, solution, reference, "reference").path);
}

} // namespace
} // namespace livermark
