#include <Eigen/Geometry>
#include <cstdio>
#include <gtest/gtest.h>
#include <memory>
#include <vector>

#include "interactive/elements/energies.hpp"
#include "interactive/method.hpp"
#include "tests/interactive/moving_scene.hpp"
#include "tests/oracles/equilibria.hpp"
#include "tests/oracles/slow_methods.hpp"

namespace livermark {
namespace {

using interactive::Field;
using tests::bar_scene;
using tests::noise;

/// The bar in motion and under forces, while its constrained end moves.
std::unique_ptr<interactive::Simulation> moving_bar(const interactive::Method &method, double time_step) {
    auto simulation = method.prepare(bar_scene(true, 0.45, 3.0));
    const Eigen::Index n = simulation->positions().cols();
    Field v = noise(n, 0.1, 1);
    for (const int node : simulation->scene().constrained_nodes)
        v.col(node).setZero();
    simulation->set_state(simulation->positions() + noise(n, 5e-4, 2), v);
    simulation->set_external_forces(noise(n, 5e-3, 3));
    simulation->set_targets(simulation->targets().colwise() + core::Vector3(0.0, 0.1 * time_step, 0.2 * time_step));
    return simulation;
}

/// Distance from backward Euler by Newton's method, over how far that is from where the nodes would go without
/// elasticity.
double distance_from_backward_euler(const interactive::Method &method, double time_step, int iterations) {
    const auto simulation = moving_bar(method, time_step);
    const auto expected = tests::backward_euler(*simulation, time_step);
    EXPECT_TRUE(expected.converged);
    const Field predicted = interactive::inertia(*simulation, time_step).predicted;
    simulation->step(time_step, iterations);
    return (simulation->positions() - expected.positions).norm() / (expected.positions - predicted).norm();
}

/// Those that descend on what backward Euler minimises.
struct DescendingMethod : testing::TestWithParam<const char *> {
    const interactive::Method method = tests::slow_method(GetParam());
};

TEST_P(DescendingMethod, ComesToTheStepOfBackwardEulerAsIterationsGrow) {
    double last = 1.0;
    for (const int iterations : {10, 40, 160}) {
        const double distance = distance_from_backward_euler(method, 5e-3, iterations);
        EXPECT_LT(distance, last);
        last = distance;
    }
    EXPECT_LT(distance_from_backward_euler(method, 5e-3, 5000), 1e-7);
}

INSTANTIATE_TEST_SUITE_P(All, DescendingMethod,
                         testing::Values("fast_mass_spring", "projective_dynamics", "vertex_block_descent"));

/// Those that add up what constraints do along gradients that turn on the way.
struct PositionBasedMethod : testing::TestWithParam<const char *> {
    const interactive::Method method = tests::slow_method(GetParam());
};

TEST_P(PositionBasedMethod, ComesToTheStepOfBackwardEulerWithTheSquareOfTheTimeStep) {
    std::vector<double> distances;
    for (const double h : {4e-4, 2e-4, 1e-4})
        distances.push_back(distance_from_backward_euler(method, h, 300));
    EXPECT_LT(distances[0], 0.05);
    EXPECT_LT(distances[1], distances[0] / 3.0);
    EXPECT_LT(distances[2], distances[1] / 3.0);
    std::printf("%s: %.2g, %.2g, %.2g of the step of backward Euler at 0.4, 0.2, 0.1 ms; %.2g at 5 ms\n",
                method.name.c_str(), distances[0], distances[1], distances[2],
                distance_from_backward_euler(method, 5e-3, 5000));
}

TEST_P(PositionBasedMethod, ComesToAStepOfItsOwnAsIterationsGrow) {
    const auto after = [&](int iterations) {
        const auto simulation = moving_bar(method, interactive::frame_time);
        simulation->step(interactive::frame_time, iterations);
        return simulation->positions();
    };
    const Field end = after(5000);
    const double few = (after(1) - end).norm(), more = (after(20) - end).norm(), many = (after(400) - end).norm();
    EXPECT_LT(more, 0.5 * few);
    EXPECT_LT(many, 0.01 * few);
}

TEST_P(PositionBasedMethod, HasTheForcesOfItsEnergyWhereIterationsHaveConverged) {
    const auto simulation = moving_bar(method, 1e-3);
    simulation->step(1e-3, 20000);
    Field forces = Field::Zero(3, simulation->positions().cols());
    simulation->energy().add_forces(simulation->positions(), forces);
    EXPECT_LT((simulation->elastic_forces() - forces).norm(), 1e-8 * forces.norm());
}

TEST_P(PositionBasedMethod, IsSofterWithOneIterationThanItsMaterial) {
    const auto simulation = method.prepare(bar_scene(true));
    simulation->set_external_forces(core::Vector3(0.0, 0.0, -1e-3).replicate(1, simulation->positions().cols()));
    const auto expected = tests::equilibrium(*simulation);
    ASSERT_TRUE(expected.converged);
    tests::settle(*simulation, interactive::frame_time, 1, 1e-5, 1000);
    const double ratio = simulation->positions().row(2).minCoeff() / expected.positions.row(2).minCoeff();
    std::printf("%s: with one iteration in 1/60 s the bar sags %.2f times as far\n", method.name.c_str(), ratio);
    EXPECT_GT(ratio, 1.05);
}

INSTANTIATE_TEST_SUITE_P(All, PositionBasedMethod, testing::Values("xpbd_springs", "xpbd_neo_hookean"));

/// Those that find the equilibrium of Newton's path by their own steps.
struct SettlingMethod : testing::TestWithParam<const char *> {
    const interactive::Method method = tests::slow_method(GetParam());
};

TEST_P(SettlingMethod, ComesToTheEquilibriumOfItsEnergyByItsOwnSteps) {
    const auto simulation = method.prepare(bar_scene(true));
    simulation->set_external_forces(core::Vector3(1e-3, 0.0, -3e-3).replicate(1, simulation->positions().cols()));
    const auto expected = tests::equilibrium(*simulation);
    ASSERT_TRUE(expected.converged);
    const auto settled = tests::settle(*simulation, 0.01, 20, 1e-9, 5000);
    EXPECT_TRUE(settled.converged);
    const double size = (expected.positions - interactive::rest_positions(simulation->scene())).norm();
    EXPECT_LT((simulation->positions() - expected.positions).norm(), 1e-5 * size);
}

INSTANTIATE_TEST_SUITE_P(All, SettlingMethod, testing::Values("vertex_block_descent"));

/// Those that begin a step where inertia and loads lead: with few iterations they rest in a softer shape.
struct PrefactoredMethod : testing::TestWithParam<const char *> {
    const interactive::Method method = tests::slow_method(GetParam());

    /// Over the displacement at rest, from where Newton's method rests.
    double drift(int iterations) const {
        const auto simulation = method.prepare(bar_scene(true));
        simulation->set_external_forces(core::Vector3(1e-3, 0.0, -3e-3).replicate(1, simulation->positions().cols()));
        const auto expected = tests::equilibrium(*simulation);
        EXPECT_TRUE(expected.converged);
        simulation->set_state(expected.positions, Field::Zero(3, expected.positions.cols()));
        for (int k = 0; k < 20; ++k)
            simulation->step(0.01, iterations);
        const double size = (expected.positions - interactive::rest_positions(simulation->scene())).norm();
        return (simulation->positions() - expected.positions).norm() / size;
    }
};

TEST_P(PrefactoredMethod, StaysInTheEquilibriumOfItsEnergyOnceItsIterationsConverge) {
    EXPECT_LT(drift(400), 1e-5);
    EXPECT_GT(drift(1), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(All, PrefactoredMethod, testing::Values("projective_dynamics", "fast_mass_spring"));

TEST(Projections, FindTheNearestPointOfUnitProduct) {
    const core::Vector3 s(1.3, 0.9, 0.8);
    const auto p = interactive::densities::nearest_of_unit_product(s);
    EXPECT_NEAR(p.prod(), 1.0, 1e-12);
    const core::Vector3 slopes(p.y() * p.z(), p.z() * p.x(), p.x() * p.y());
    EXPECT_LT((p - s).cross(slopes).norm(), 1e-12); // at right angles to the surface
    for (const double a : {-0.01, 0.01})
        for (const double b : {-0.01, 0.01}) {
            const core::Vector3 other(p.x() + a, p.y() + b, 1.0 / ((p.x() + a) * (p.y() + b)));
            EXPECT_GT((other - s).norm(), (p - s).norm());
        }
}

TEST(Projections, KeepRotationsRight) {
    Eigen::Matrix3d f;
    f << 1.1, 0.3, 0.0, -0.2, 0.9, 0.1, 0.0, 0.2, -1.2; // inside out
    const auto [u, v, s] = interactive::densities::signed_svd(f);
    EXPECT_NEAR(u.determinant(), 1.0, 1e-12);
    EXPECT_NEAR(v.determinant(), 1.0, 1e-12);
    EXPECT_LT((u * s.asDiagonal() * v.transpose() - f).norm(), 1e-12);
    EXPECT_LT(s[2], 0.0);
}

} // namespace
} // namespace livermark
