#include <gtest/gtest.h>

#include "msm/kernels/layout/slicing.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/springs/volume_penalty.hpp"
#include "tests/samples/moving_samples.hpp"

namespace livermark {
namespace {

msm::StepParts parts_of_springs(const core::Body &body, const char *springs) {
    return msm::step_parts(msm::coupled_springs_with_volume(body, msm::find_coupled_springs(springs))).value();
}

TEST(VolumeMeans, AreThoseOfTheVolumeTerm) {
    const auto body = tests::two_materials(108, 0.25, 0.45);
    const auto means = msm::volume_means(parts_of_springs(body, "edge_neo_hookean"), body.mesh.points);
    const Eigen::MatrixXd expected = msm::mean_volumes_around_nodes(msm::nodal_parts(body), {1.0, 1.0}).mean;
    ASSERT_EQ(static_cast<Eigen::Index>(means.size()), expected.rows());
    Eigen::MatrixXd found = 0.25 * Eigen::MatrixXd::Identity(expected.rows(), expected.cols());
    for (std::size_t c = 0; c < means.size(); ++c)
        for (const auto &[other, weight] : means[c])
            found(static_cast<Eigen::Index>(c), other) += weight;
    EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(VolumeMeans, AreAskedBesideEdgesAlone) {
    const auto body = tests::two_materials(108, 0.25, 0.45);
    EXPECT_TRUE(msm::volume_means(parts_of_springs(body, "nodal_neo_hookean"), body.mesh.points).empty());
}

/// Fast kernels take other means for those over corners.
TEST(VolumeMeans, OfAnotherKindAreNotInKernels) {
    const auto body = tests::two_materials(108, 0.45, 0.45);
    const auto parts = msm::nodal_parts(body);
    for (const bool are_known : {true, false}) {
        auto volumes = msm::mean_volumes_around_nodes(parts, {1e4, 1e4});
        volumes.measure = msm::logarithm_of_volume;
        if (!are_known)
            volumes.mean.setIdentity();
        const msm::ElasticBody springs({}, {msm::coupled_springs(body, msm::find_coupled_springs("edge_neo_hookean")),
                                            msm::volume_penalty(body.mesh, volumes)});
        EXPECT_EQ(msm::step_parts(springs).has_value(), are_known);
    }
}

} // namespace
} // namespace livermark
