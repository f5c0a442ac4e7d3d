#include "msm/kernels/layout/slicing.hpp"

#include <gtest/gtest.h>

#include "core/mesh/tetra_mesh.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "tests/samples/moving_samples.hpp"

namespace livermark {
namespace {

const core::Body &body_of_two() {
    static const auto body = tests::two_materials(108, 0.25, 0.45);
    return body;
}

msm::StepParts parts_of(const char *springs) {
    const auto body = msm::coupled_springs_with_volume(body_of_two(), msm::find_coupled_springs(springs));
    return msm::step_parts(body).value();
}

TEST(MeanGradients, AreThoseOfALinearFieldAroundEveryNode) {
    const auto &points = body_of_two().mesh.points;
    const auto parts = parts_of("nodal_neo_hookean_f");
    const auto gradients = msm::mean_gradients(parts, points);
    ASSERT_EQ(gradients.size(), parts.centre.size());
    for (std::size_t c = 0; c < gradients.size(); ++c) {
        Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
        for (const auto &[node, gradient, stiffness] : gradients[c])
            mean += (points[node] - points[parts.centre[c]]) * gradient.transpose();
        EXPECT_LT((mean - Eigen::Matrix3d::Identity()).norm(), 1e-12) << c;
    }
}

/// Half of mu tr C in every tetrahedron, and each edge is found from both of its ends.
TEST(MeanGradients, HaveTheEnergyOfSpringsInsideTetrahedraAlongEdges) {
    const auto &mesh = body_of_two().mesh;
    const auto parts = parts_of("nodal_neo_hookean_f");
    double of_edges = 0.0, of_tetrahedra = 0.0;
    const auto gradients = msm::mean_gradients(parts, mesh.points);
    for (std::size_t c = 0; c < gradients.size(); ++c)
        for (const auto &[node, gradient, stiffness] : gradients[c])
            of_edges += 0.25 * stiffness * (mesh.points[node] - mesh.points[parts.centre[c]]).squaredNorm();
    const auto volumes = core::tetrahedron_volumes(mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        of_tetrahedra += 1.5 * parts.inner_modulus[t] * volumes[t];
    EXPECT_NEAR(of_edges, of_tetrahedra, 1e-12 * of_tetrahedra);
}

TEST(MeanGradients, AreAskedByMeansOfFAlone) {
    for (const auto *springs : {"nodal_springs", "nodal_neo_hookean"})
        EXPECT_TRUE(msm::mean_gradients(parts_of(springs), body_of_two().mesh.points).empty()) << springs;
}

} // namespace
} // namespace livermark
