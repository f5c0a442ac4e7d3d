#include <Eigen/Dense>
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

/// Methods that descend on what backward Euler minimises.
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

/// Methods that add up what constraints do along gradients that turn on the way.
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

/// Methods that begin a step where inertia and loads lead: with few iterations they rest in a softer shape.
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

/// The matrix that turns with the elements, put together node by node: sum of R_t K_ab R_t^T with K_ab of linear
/// elasticity, V (lambda g_a g_b^T + mu g_b g_a^T + mu (g_a . g_b) 1).
Eigen::MatrixXd warped_stiffness(const interactive::Scene &scene, const Field &x) {
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(x.size(), x.size());
    for (const auto &t : interactive::tetrahedra_at_rest(*scene.body)) {
        const Eigen::Matrix3d r = interactive::densities::nearest_rotation(t.gradient(x));
        const auto g = t.shape_gradients();
        for (int a = 0; a < 4; ++a)
            for (int b = 0; b < 4; ++b) {
                const Eigen::Vector3d ga = g.row(a).transpose(), gb = g.row(b).transpose();
                const Eigen::Matrix3d block = t.volume * (t.lambda * ga * gb.transpose() + t.mu * gb * ga.transpose() +
                                                          t.mu * ga.dot(gb) * Eigen::Matrix3d::Identity());
                matrix.block<3, 3>(3 * t.nodes[a], 3 * t.nodes[b]) += r * block * r.transpose();
            }
    }
    return matrix;
}

TEST(CorotationalImplicit, StepIsThatOfADenseSolveOfTheLinearisedBackwardEuler) {
    const double h = 5e-3, alpha = 3.0;
    const auto scene = bar_scene(true, 0.45, alpha);
    const auto simulation = tests::slow_method("corotational_implicit").prepare(scene);
    const Eigen::Index n = simulation->positions().cols();
    const Field x = simulation->positions() + noise(n, 1e-3, 1), v = noise(n, 0.1, 2), external = noise(n, 1e-2, 3);
    simulation->set_state(x, v);
    simulation->set_external_forces(external);
    const Field targets = simulation->targets().colwise() + core::Vector3(1e-4, 0.0, 2e-4);
    simulation->set_targets(targets);

    const Eigen::MatrixXd k = warped_stiffness(scene, x);
    // f = -R K (R^T x - x_0), from the same blocks
    Eigen::VectorXd right = Eigen::VectorXd::Zero(3 * n);
    Field f = Field::Zero(3, n);
    simulation->energy().add_forces(x, f);
    Eigen::MatrixXd a = h * h * k;
    for (Eigen::Index j = 0; j < 3 * n; ++j) {
        a(j, j) += scene.node_mass[j / 3] * (1.0 + alpha * h);
        right[j] = scene.node_mass[j / 3] * v.data()[j] + h * (f.data()[j] + external.data()[j]);
    }
    for (Eigen::Index c = 0; c < targets.cols(); ++c)
        for (int i = 0; i < 3; ++i) {
            const Eigen::Index row = 3 * scene.constrained_nodes[c] + i;
            a.row(row).setZero();
            a(row, row) = 1.0;
            right[row] = (targets(i, c) - x.data()[row]) / h;
        }
    const Eigen::VectorXd velocity = a.partialPivLu().solve(right);

    simulation->step(h, 500);
    const Eigen::Map<const Eigen::VectorXd> found(simulation->velocities().data(), 3 * n);
    EXPECT_LT((found - velocity).norm(), 1e-8 * velocity.norm());
}

TEST(DescendingSteps, ComeToTheEquilibriumOfTheirEnergy) {
    const auto distance = [](const char *name, const core::Vector3 &force, double time_step, int iterations,
                             double tolerance, int steps) {
        const auto simulation = tests::slow_method(name).prepare(bar_scene(true));
        simulation->set_external_forces(force.replicate(1, simulation->positions().cols()));
        const auto expected = tests::equilibrium(*simulation);
        EXPECT_TRUE(expected.converged);
        EXPECT_TRUE(tests::settle(*simulation, time_step, iterations, tolerance, steps).converged);
        const Field rest = interactive::rest_positions(simulation->scene());
        EXPECT_LT(expected.positions.row(2).minCoeff(), force.z()); // so large that rotations matter
        return (simulation->positions() - expected.positions).norm() / (expected.positions - rest).norm();
    };
    EXPECT_LT(distance("corotational_implicit", {0.0, 0.0, -8e-3}, 0.1, 300, 1e-11, 3000), 1e-7);
    EXPECT_LT(distance("vertex_block_descent", {1e-3, 0.0, -3e-3}, 0.01, 20, 1e-9, 5000), 1e-5);
}

TEST(CorotationalImplicit, StepIsNearerAfterAsManyIterationsWithItsPreconditioner) {
    using tests::Preconditioner;
    const auto after = [](Preconditioner preconditioner, int iterations) {
        tests::Corotational simulation(tests::uneven_scene({5, 3, 3}, true), preconditioner);
        simulation.set_external_forces(core::Vector3(1e-3, 0.0, -4e-3).replicate(1, simulation.positions().cols()));
        simulation.step(interactive::frame_time, iterations);
        return simulation.positions();
    };
    const Field end = after(Preconditioner::none, 2000);
    EXPECT_LT((after(Preconditioner::blocks, 2000) - end).norm(), 1e-12);
    for (const int iterations : {10, 20, 40, 80}) // one to five leave more
        EXPECT_LT((after(Preconditioner::blocks, iterations) - end).norm(),
                  0.8 * (after(Preconditioner::none, iterations) - end).norm())
            << iterations;
}

TEST(CorotationalImplicit, StepComesToBackwardEulerWithTheFourthPowerOfTheTimeStep) {
    // Both start from the same state; their new velocities differ by what linearisation neglects.
    std::vector<double> differences;
    for (const double h : {2e-4, 1e-4, 5e-5}) {
        const auto simulation = tests::slow_method("corotational_implicit").prepare(bar_scene(true));
        const Eigen::Index n = simulation->positions().cols();
        Field v = noise(n, 0.2, 4);
        for (const int node : simulation->scene().constrained_nodes)
            v.col(node).setZero();
        simulation->set_state(simulation->positions(), v);
        const auto expected = tests::backward_euler(*simulation, h);
        ASSERT_TRUE(expected.converged);
        simulation->step(h, 1000);
        differences.push_back((simulation->positions() - expected.positions).norm());
    }
    EXPECT_LT(differences[1], differences[0] / 12.0); // h^4: forces differ by (h v)^2, positions by h^2 of that
    EXPECT_LT(differences[2], differences[1] / 12.0);
}

} // namespace
} // namespace livermark
