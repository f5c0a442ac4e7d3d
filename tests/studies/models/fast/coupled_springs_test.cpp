#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>
#include <random>

#include "fem_reference/linear/linear_elasticity.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/springs/spring_network.hpp"
#include "msm/springs/tetrahedron.hpp"
#include "msm/springs/volume_penalty.hpp"
#include "msm/statics/equilibrium.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/oracles/linear_elements.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

/// Springs of Hooke's law with another part inside tetrahedra.
std::shared_ptr<const msm::ElasticTerm> springs_of(const core::Body &body, double part) {
    return msm::coupled_springs(body, msm::with_part_inside(msm::find_coupled_springs("nodal_springs"), part));
}

constexpr double some = 0.2;

std::shared_ptr<const core::Body> box_of(double poisson_ratio) {
    return tests::make_body(tests::shaken_box_mesh({0.1, 0.08, 0.06}, {5, 4, 3}), {1060.0, 5000.0, poisson_ratio});
}

Eigen::VectorXd shaken(const core::Body &body) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> offset(-0.02, 0.02);
    auto moved = body.mesh.points;
    for (auto &x : moved)
        x += Vector3(offset(random), offset(random), offset(random));
    return msm::to_unknowns(moved);
}

/// Nothing is left to the nodes, so for small strains they are linear elements.
TEST(NodalSprings, AreLinearElementsWhereAllStiffnessIsInsideTetrahedra) {
    const auto body = box_of(0.25);
    const auto rest = msm::to_unknowns(body->mesh.points);
    const Eigen::SparseMatrix<double> found = springs_of(*body, 1.0)->hessian(rest, msm::Tangent::exact);
    const Eigen::SparseMatrix<double> expected = tests::linear_elements(*body)->hessian(rest, msm::Tangent::exact);
    EXPECT_LT((found - expected).norm(), 1e-13 * expected.norm());
}

/// Means of a strain that is the same everywhere are that strain: V mu (1/2 (tr E)^2 + E : E), whatever the part
/// inside.
TEST(NodalSprings, HaveTheEnergyOfTheSolidWhereTheStrainIsTheSameEverywhere) {
    const auto body = box_of(0.25);
    Eigen::Matrix3d strain;
    strain << 2.0, 0.5, -1.0, 0.5, -1.0, 0.8, -1.0, 0.8, 1.5;
    strain *= 1e-6;
    auto moved = body->mesh.points;
    for (auto &x : moved)
        x += strain * x;
    double volume = 0.0;
    for (const double v : core::tetrahedron_volumes(body->mesh))
        volume += v;
    const double expected = volume * body->materials.front().shear_modulus() *
                            (0.5 * strain.trace() * strain.trace() + strain.squaredNorm());
    for (const double part : {0.0, some, 1.0})
        EXPECT_NEAR(springs_of(*body, part)->energy(msm::to_unknowns(moved)), expected, 1e-5 * expected);
}

/// A bar of one material that is pulled to twice its length takes twice the force of 1.5 times its length: elongations,
/// not their squares.
TEST(NodalSprings, PullInProportionToTheElongation) {
    const auto body = box_of(0.25);
    const auto force_at = [&](double elongation) {
        Eigen::VectorXd x = (1.0 + elongation) * msm::to_unknowns(body->mesh.points);
        Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
        springs_of(*body, some)->add_force(x, x, 0.0, force);
        return force;
    };
    const auto half = force_at(0.5), whole = force_at(1.0);
    EXPECT_LT((whole - 2.0 * half).norm(), 1e-12 * whole.norm());
    EXPECT_GT(half.norm(), 0.0);
}

/// Strains that cancel around every node cost nothing but what they cost inside the tetrahedra; means around edges
/// leave nothing free by themselves.
TEST(CoupledSprings, LeaveNoMotionFree) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.08, 0.06}, {3, 2, 2}), {1060.0, 5000.0, 0.25});
    const auto rest = msm::to_unknowns(body->mesh.points);
    const auto least = [&](const msm::CoupledSprings &springs) {
        const Eigen::MatrixXd stiffness = msm::coupled_springs(*body, springs)->hessian(rest, msm::Tangent::exact);
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(stiffness, Eigen::EigenvaluesOnly);
        const double largest = eigen.eigenvalues().maxCoeff();
        EXPECT_EQ((eigen.eigenvalues().array() < 1e-10 * largest).count(), 6) << springs.name;
        return eigen.eigenvalues()[6] / largest;
    };
    for (const auto &springs : msm::all_coupled_springs()) {
        EXPECT_GT(least(springs), 1e-3) << springs.name;
        if (springs.domains.edges > 0.0) {
            EXPECT_GT(least(msm::with_part_inside(springs, 0.0)), 1e-3) << springs.name;
        }
    }
}

/// A mean has a smaller square than what it is of, and around nodes it is one that leaves the sum alone.
TEST(MeansOfVolumes, CostNoMoreThanTheVolumesThemselves) {
    const auto body = box_of(0.45);
    const auto x = shaken(*body);
    const auto parts = msm::nodal_parts(*body);
    const double mean = msm::volume_penalty(body->mesh, msm::mean_volumes_around_nodes(parts, {1e4}))->energy(x);
    const double own = msm::volume_penalty(body->mesh, msm::volumes_around_nodes(parts, {1e4}))->energy(x);
    EXPECT_LT(mean, 0.9 * own);
    EXPECT_GT(mean, 0.0);
}

class NodalSpringsModel : public testing::TestWithParam<double> {};

/// Against quadratic finite elements on the same mesh, which at 0.49 lock a little themselves, linear ones lose at
/// least twice as much.
TEST_P(NodalSpringsModel, IsTwiceAsGoodAsLinearFiniteElements) {
    const auto body = box_of(GetParam());
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
    tests::pull(load_case, body->mesh, "x_max", {3.0, 5.0, -2.0});
    const core::Problem problem{body, load_case};
    const auto springs = msm::coupled_springs_with_volume(*body, msm::find_coupled_springs("nodal_springs"));
    const auto found =
        msm::find_equilibrium(springs, body->mesh.points, msm::nodal_conditions(problem, springs.node_mass))
            .linear_displacement;
    const auto expected = fem_reference::StaticSolver(body, 2).solve(load_case).displacement;
    const auto linear = fem_reference::StaticSolver(body, 1).solve(load_case).displacement;
    EXPECT_LT(tests::relative_difference(found, expected), 0.5 * tests::relative_difference(linear, expected));
}

INSTANTIATE_TEST_SUITE_P(PoissonRatio, NodalSpringsModel, testing::Values(0.25, 0.45, 0.49),
                         [](const auto &info) { return "nu_" + std::to_string(std::lround(100.0 * info.param)); });

} // namespace
} // namespace livermark
