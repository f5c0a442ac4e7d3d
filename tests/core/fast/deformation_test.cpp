#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>

#include "core/error_norms.hpp"
#include "core/mesh/deformation.hpp"
#include "tests/samples/test_meshes.hpp"

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
