#include <Eigen/Eigenvalues>
#include <cmath>
#include <gtest/gtest.h>

#include "interactive/equilibrium.hpp"
#include "interactive/method.hpp"
#include "tests/interactive/moving_scene.hpp"

namespace livermark {
namespace {

using interactive::Field;
using tests::bar_scene;
using tests::noise;

struct TotalLagrangianExplicit : testing::TestWithParam<const char *> {
    const interactive::Method &method = interactive::find_method(GetParam());
};

/// The bar under its weight and more, at x = 0 constrained.
void load(interactive::Simulation &simulation) {
    simulation.set_external_forces(
        core::Vector3(1e-3, 0.0, -8e-3).replicate(1, simulation.scene().body->mesh.num_nodes()));
}

TEST_P(TotalLagrangianExplicit, ComesToTheEquilibriumOfItsEnergyByItsOwnSteps) {
    const auto simulation = method.prepare(bar_scene(true, 0.45, 20.0));
    load(*simulation);
    const auto expected = interactive::equilibrium(*simulation);
    ASSERT_TRUE(expected.converged);
    const double h = 0.8 * simulation->critical_time_step();
    for (int i = 0; i < 40; ++i)
        simulation->step(100.0 * h, 100);
    const double size = (expected.positions - interactive::rest_positions(simulation->scene())).norm();
    EXPECT_LT((simulation->positions() - expected.positions).norm(), 1e-6 * size);
    EXPECT_LT(expected.positions.row(2).minCoeff(), -0.01);
}

/// The highest frequency of the whole, from its matrix.
double critical_step_of_the_whole(const interactive::Simulation &simulation) {
    const Eigen::Index n = simulation.positions().size();
    interactive::Energy::Triplets triplets;
    simulation.energy().add_hessian(simulation.positions(), false, triplets);
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
    const auto &mass = simulation.scene().node_mass;
    for (const auto &entry : triplets)
        matrix(entry.row(), entry.col()) += entry.value() / std::sqrt(mass[entry.row() / 3] * mass[entry.col() / 3]);
    return 2.0 /
           std::sqrt(
               Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff());
}

TEST_P(TotalLagrangianExplicit, SaysAStepThatIsStable) {
    const auto simulation = method.prepare(bar_scene(false));
    const double whole = critical_step_of_the_whole(*simulation);
    EXPECT_LE(simulation->critical_time_step(), whole * (1.0 + 1e-9));
    EXPECT_GT(simulation->critical_time_step(), 0.3 * whole);
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
    const auto found = interactive::equilibrium(*simulation);
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
