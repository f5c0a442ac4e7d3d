#include <Eigen/Dense>
#include <gtest/gtest.h>

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

TEST(CorotationalImplicit, ComesToTheEquilibriumOfItsEnergyByItsOwnSteps) {
    const auto simulation = tests::slow_method("corotational_implicit").prepare(bar_scene(true));
    simulation->set_external_forces(core::Vector3(0.0, 0.0, -8e-3).replicate(1, simulation->positions().cols()));
    const auto expected = tests::equilibrium(*simulation);
    ASSERT_TRUE(expected.converged);
    const auto settled = tests::settle(*simulation, 0.1, 300, 1e-11, 3000);
    EXPECT_TRUE(settled.converged);
    const double largest = (expected.positions - interactive::rest_positions(simulation->scene())).norm();
    EXPECT_LT((simulation->positions() - expected.positions).norm(), 1e-7 * largest);
    EXPECT_LT(expected.positions.row(2).minCoeff(), -0.01); // so large that rotations matter
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
