#include <Eigen/Eigenvalues>
#include <cmath>
#include <gtest/gtest.h>

#include "interactive/elements/explicit_tetrahedra.hpp"
#include "interactive/method.hpp"
#include "tests/interactive/moving_scene.hpp"
#include "tests/oracles/equilibria.hpp"
#include "tests/oracles/slow_methods.hpp"

namespace livermark {
namespace {

using interactive::Field;
using tests::bar_scene;
using tests::noise;

/// With their steps in double precision.
struct TotalLagrangianExplicit : testing::TestWithParam<const char *> {
    const interactive::Method method = tests::slow_method(GetParam());
};

/// The bar under its weight and more, at x = 0 constrained.
void load(interactive::Simulation &simulation) {
    simulation.set_external_forces(
        core::Vector3(1e-3, 0.0, -8e-3).replicate(1, simulation.scene().body->mesh.num_nodes()));
}

TEST_P(TotalLagrangianExplicit, ComesToTheEquilibriumOfItsEnergyByItsOwnSteps) {
    const auto simulation = method.prepare(bar_scene(true, 0.45, 20.0));
    load(*simulation);
    const auto expected = tests::equilibrium(*simulation);
    ASSERT_TRUE(expected.converged);
    const double h = 0.8 * simulation->critical_time_step();
    for (int i = 0; i < 40; ++i)
        simulation->step(100.0 * h, 100);
    const double size = (expected.positions - interactive::rest_positions(simulation->scene())).norm();
    EXPECT_LT((simulation->positions() - expected.positions).norm(), 1e-6 * size);
    EXPECT_LT(expected.positions.row(2).minCoeff(), -0.01);
}

/// From the highest frequency of the whole, by its matrix over the free components.
double critical_step_by_matrix(const interactive::Simulation &simulation) {
    const Eigen::Index n = simulation.positions().size();
    interactive::Energy::Triplets triplets;
    simulation.energy().add_hessian(simulation.positions(), false, triplets);
    const auto &scene = simulation.scene();
    const auto is_free = interactive::free_nodes(scene);
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
    for (const auto &entry : triplets)
        if (is_free[entry.row() / 3] && is_free[entry.col() / 3])
            matrix(entry.row(), entry.col()) +=
                entry.value() / std::sqrt(scene.node_mass[entry.row() / 3] * scene.node_mass[entry.col() / 3]);
    return 2.0 /
           std::sqrt(
               Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff());
}

TEST_P(TotalLagrangianExplicit, KnowsItsCriticalTimeStep) {
    for (const bool is_constrained : {false, true}) {
        const auto simulation = method.prepare(bar_scene(is_constrained));
        const double expected = critical_step_by_matrix(*simulation);
        EXPECT_NEAR(simulation->critical_time_step(), expected, 1e-4 * expected);
    }
}

TEST_P(TotalLagrangianExplicit, IsStableJustBelowItAndNotAbove) {
    for (const auto &[factor, is_stable] : {std::pair(0.98, true), std::pair(1.03, false)}) {
        const auto simulation = method.prepare(bar_scene(true));
        simulation->set_state(simulation->positions(), noise(simulation->positions().cols(), 1e-6, 1));
        const double h = factor * simulation->critical_time_step();
        for (int i = 0; i < 20; ++i)
            simulation->step(100.0 * h, 100);
        const auto &v = simulation->velocities();
        EXPECT_EQ(v.allFinite() && v.norm() < 1e-3, is_stable) << factor;
    }
}

TEST(CriticalTimeStepBound, IsNotAboveTheCriticalTimeStep) {
    const auto scene = bar_scene(false);
    const auto simulation = interactive::find_method("tled").prepare(scene);
    const double bound =
        interactive::critical_time_step_bound(interactive::tetrahedra_at_rest(*scene.body), scene.node_mass);
    EXPECT_LE(bound, simulation->critical_time_step() * (1.0 + 1e-4));
    EXPECT_GT(bound, 0.2 * simulation->critical_time_step());
}

double energy_of(const interactive::Simulation &simulation) {
    double energy = simulation.energy().value(simulation.positions());
    for (Eigen::Index i = 0; i < simulation.velocities().cols(); ++i)
        energy += 0.5 * simulation.scene().node_mass[i] * simulation.velocities().col(i).squaredNorm();
    return energy;
}

TEST_P(TotalLagrangianExplicit, KeepsEnergyWithinAFewPercentOverManySteps) {
    const auto simulation = method.prepare(bar_scene(false));
    simulation->set_state(simulation->positions(), noise(simulation->positions().cols(), 0.1, 1));
    const double start = energy_of(*simulation);
    const double h = 0.2 * simulation->critical_time_step();
    for (int i = 0; i < 50; ++i) {
        simulation->step(100.0 * h, 100);
        EXPECT_NEAR(energy_of(*simulation), start, 0.05 * start);
    }
}

TEST_P(TotalLagrangianExplicit, ComesToTheMotionWithTheSquareOfTheTimeStep) {
    std::vector<Field> ends;
    for (const int iterations : {80, 160, 320}) {
        const auto simulation = method.prepare(bar_scene(true));
        load(*simulation);
        // Velocities are half a step behind: at rest now, they were minus half of a step's acceleration.
        Field v = simulation->external_forces();
        for (Eigen::Index i = 0; i < v.cols(); ++i)
            v.col(i) *= -0.5 * 0.02 / iterations / simulation->scene().node_mass[i];
        simulation->set_state(simulation->positions(), v);
        simulation->step(0.02, iterations);
        ends.push_back(simulation->positions());
    }
    const double ratio = (ends[1] - ends[0]).norm() / (ends[2] - ends[1]).norm();
    EXPECT_GT(ratio, 3.7);
    EXPECT_LT(ratio, 4.3);
}

/// How far the bar's lowest node goes down.
double sag(const interactive::Method &method, double poisson_ratio) {
    const auto simulation = method.prepare(bar_scene(true, poisson_ratio));
    load(*simulation);
    const auto found = tests::equilibrium(*simulation);
    EXPECT_TRUE(found.converged);
    return -found.positions.row(2).minCoeff();
}

TEST(NodalPressureAndQuadraticTetrahedra, DoNotLockWherePlainTetrahedraDo) {
    const auto &plain = interactive::find_method("tled");
    EXPECT_LT(sag(plain, 0.499), 0.6 * sag(plain, 0.45));
    for (const char *const name : {"tled_nodal_pressure", "tled_quadratic"}) {
        const auto &method = interactive::find_method(name);
        EXPECT_GT(sag(method, 0.499), 0.8 * sag(method, 0.45)) << name;
    }
}

INSTANTIATE_TEST_SUITE_P(All, TotalLagrangianExplicit,
                         testing::Values("tled", "tled_nodal_pressure", "tled_quadratic"));

} // namespace
} // namespace livermark
