#include <Eigen/LU>
#include <algorithm>
#include <gtest/gtest.h>
#include <random>

#include "fem_reference/linear/linear_elasticity.hpp"
#include "msm/elastic_body.hpp"
#include "msm/statics/equilibrium.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/oracles/linear_elements.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

std::shared_ptr<const core::Body> box(double poisson_ratio) {
    return tests::make_body(tests::shaken_box_mesh({0.1, 0.08, 0.06}, {4, 3, 3}), {1060.0, 5000.0, poisson_ratio});
}

/// Deformation gradient of a tetrahedron.
Eigen::Matrix3d deformation_gradient(const std::array<int, 4> &nodes, const std::vector<Vector3> &rest,
                                     const std::vector<Vector3> &now) {
    Eigen::Matrix3d before, after;
    for (int a = 0; a < 3; ++a) {
        before.col(a) = rest[nodes[a + 1]] - rest[nodes[0]];
        after.col(a) = now[nodes[a + 1]] - now[nodes[0]];
    }
    return after * before.inverse();
}

class LinearElements : public testing::TestWithParam<double> {};

/// V (lambda / 2 (tr E)^2 + mu E : E) with E = (F^T F - I) / 2, at deformations as large as the elements.
TEST_P(LinearElements, HaveTheEnergyOfSaintVenantAndKirchhoff) {
    const auto body = box(GetParam());
    const auto &material = body->materials.front();
    std::mt19937 random(3);
    std::uniform_real_distribution<double> offset(-0.02, 0.02);
    auto moved = body->mesh.points;
    for (auto &x : moved)
        x += Vector3(offset(random), offset(random), offset(random));
    const auto volumes = core::tetrahedron_volumes(body->mesh);
    double expected = 0.0;
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        const auto f = deformation_gradient(body->mesh.tetrahedra[t], body->mesh.points, moved);
        const Eigen::Matrix3d strain = 0.5 * (f.transpose() * f - Eigen::Matrix3d::Identity());
        expected += volumes[t] * (0.5 * material.lame_lambda() * strain.trace() * strain.trace() +
                                  material.shear_modulus() * strain.squaredNorm());
    }
    EXPECT_NEAR(tests::linear_elements(*body)->energy(msm::to_unknowns(moved)), expected, 1e-12 * expected);
}

/// Linearised, they are linear finite elements, which were put together by another library from other formulas.
TEST_P(LinearElements, AreLinearFiniteElementsUnderSmallLoads) {
    const core::Problem problem = [&] {
        const auto body = box(GetParam());
        auto load_case = tests::empty_load_case(body->mesh);
        tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
        tests::pull(load_case, body->mesh, "x_max", {10.0, 20.0, -5.0});
        load_case.acceleration = {0.1, 0.0, -0.3};
        return core::Problem{body, load_case};
    }();
    const msm::ElasticBody springs(msm::lumped_masses(*problem.body), {tests::linear_elements(*problem.body)});
    const auto found =
        msm::find_equilibrium(springs, problem.body->mesh.points, msm::nodal_conditions(problem, springs.node_mass));
    fem_reference::StaticSolver fem(problem.body, 1);
    const auto expected = fem.solve(problem.load_case).displacement;
    EXPECT_LT(tests::relative_difference(found.linear_displacement, expected), 1e-12);
    EXPECT_GT(tests::relative_difference(found.displacement, expected), 1e-4); // they are not linear
}

/// With lambda / mu of 2.5, or of 12 where lambda is above 10 mu.
TEST_P(LinearElements, OfSofterVolumeAreTheStiffnessThatPreconditions) {
    const auto body = box(GetParam());
    const auto &material = body->materials.front();
    const double mu = material.shear_modulus();
    const double lambda = std::min(material.lame_lambda(), (material.lame_lambda() > 10.0 * mu ? 12.0 : 2.5) * mu);
    const double nu = 0.5 * lambda / (lambda + mu);
    const core::Body softer{body->name, body->mesh, {{material.density, 2.0 * mu * (1.0 + nu), nu}}};
    const auto expected =
        tests::linear_elements(softer)->hessian(msm::to_unknowns(body->mesh.points), msm::Tangent::material);
    EXPECT_LT((msm::stiffness_of_softer_volume(*body, 1.0) - expected).norm(), 1e-13 * expected.norm());
}

INSTANTIATE_TEST_SUITE_P(PoissonRatio, LinearElements, testing::Values(0.0, 0.25, 0.45, 0.49),
                         [](const auto &info) { return "nu_" + std::to_string(std::lround(100.0 * info.param)); });

} // namespace
} // namespace livermark
