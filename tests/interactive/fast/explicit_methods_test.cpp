#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <vector>

#include "interactive/elements/explicit_tetrahedra.hpp"
#include "interactive/method.hpp"
#include "tests/interactive/moving_scene.hpp"
#include "tests/oracles/equilibria.hpp"
#include "tests/oracles/slow_methods.hpp"

namespace livermark {
namespace {

using core::Vector3;
using interactive::Field;
using interactive::Matrix3;
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
    for (const bool is_slow : {true, false}) {
        const auto scene = bar_scene(true, 0.45, 20.0);
        const auto simulation = is_slow ? method.prepare(scene) : interactive::find_method(GetParam()).prepare(scene);
        load(*simulation);
        const auto expected = tests::equilibrium(*simulation);
        ASSERT_TRUE(expected.converged);
        const double h = 0.8 * simulation->critical_time_step();
        for (int i = 0; i < 40; ++i)
            simulation->step(100.0 * h, 100);
        const double size = (expected.positions - interactive::rest_positions(simulation->scene())).norm();
        EXPECT_LT((simulation->positions() - expected.positions).norm(), (is_slow ? 1e-6 : 1e-4) * size);
        EXPECT_LT(expected.positions.row(2).minCoeff(), -0.01);
    }
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

/// The way down of the bar's lowest node.
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

/// Positions that are a polynomial of second degree of those at rest, and its gradient.
Vector3 bent(const Vector3 &p) {
    return {p.x() + 2.0 * p.x() * p.y() - p.z() * p.z(), p.y() + 3.0 * p.z() * p.x() + p.y() * p.y(),
            p.z() - p.x() * p.x() + p.y() * p.z()};
}

Matrix3 gradient_of_bent(const Vector3 &p) {
    Matrix3 f;
    f << 1.0 + 2.0 * p.y(), 2.0 * p.x(), -2.0 * p.z(), 3.0 * p.z(), 1.0 + 2.0 * p.y(), 3.0 * p.x(), -2.0 * p.x(), p.z(),
        1.0 + p.y();
    return f;
}

TEST(QuadraticTetrahedra, HaveTheGradientsOfPolynomialsOfSecondDegree) {
    const auto scene = interactive::quadratic_scene(bar_scene(false));
    const interactive::QuadraticEnergy energy(scene);
    const Field rest = interactive::rest_positions(scene);
    Field x = rest;
    for (Eigen::Index i = 0; i < x.cols(); ++i)
        x.col(i) = bent(rest.col(i));
    constexpr double root_of_five = 2.2360679774997897, near = (5.0 + 3.0 * root_of_five) / 20.0;
    ASSERT_EQ(energy.tetrahedra().size(), scene.body->mesh.tetrahedra.size());
    for (const auto &t : energy.tetrahedra()) {
        const auto f = t.gradients(x);
        for (int q = 0; q < 4; ++q) {
            Vector3 point = near * rest.col(t.nodes[q]);
            for (int k = 0; k < 4; ++k)
                if (k != q)
                    point += (1.0 - near) / 3.0 * rest.col(t.nodes[k]);
            EXPECT_LT((f[q] - gradient_of_bent(point)).norm(), 1e-12);
            // The same by shape functions.
            Matrix3 sum = Matrix3::Zero();
            const auto slopes = t.shape_gradients(q);
            for (int a = 0; a < 10; ++a)
                sum += x.col(t.nodes[a]) * slopes.row(a);
            EXPECT_LT((f[q] - sum).norm(), 1e-12);
        }
    }
}

TEST(QuadraticScene, KeepsTheMassAndGivesEachNodeSomeOfIt) {
    const auto given = bar_scene(true);
    const auto scene = interactive::quadratic_scene(given);
    EXPECT_GT(std::ranges::min(scene.node_mass), 0.0);
    const auto sum = [](const std::vector<double> &mass) { return std::accumulate(mass.begin(), mass.end(), 0.0); };
    EXPECT_NEAR(sum(scene.node_mass), sum(given.node_mass), 1e-12 * sum(given.node_mass));
}

/// All nodes at x = 0, corners or middles, and no other.
TEST(QuadraticScene, ConstrainsTheMiddlesOfConstrainedFacets) {
    const auto scene = interactive::quadratic_scene(bar_scene(true));
    const Field rest = interactive::rest_positions(scene);
    const auto is_free = interactive::free_nodes(scene);
    ASSERT_GT(rest.cols(), bar_scene(true).body->mesh.num_nodes());
    for (Eigen::Index i = 0; i < rest.cols(); ++i)
        EXPECT_EQ(is_free[i], rest(0, i) > 0.0);
}

TEST(QuadraticScene, LeavesTheMiddleFreeWhereNoFacetIsConstrained) {
    auto given = bar_scene(false);
    const auto &corners = given.body->mesh.boundary_triangles.front();
    given.constrained_nodes = {corners[0], corners[1]};
    EXPECT_TRUE(interactive::quadratic_scene(given).followers.empty());
    given.constrained_nodes.push_back(corners[2]);
    EXPECT_EQ(interactive::quadratic_scene(given).followers.size(), 3U);
}

TEST(QuadraticScene, CarriesTheForcesOfMiddlesAtTheirEnds) {
    const auto scene = interactive::quadratic_scene(bar_scene(true));
    const Field forces = noise(interactive::num_nodes(scene), 1.0, 5);
    const Field pushed = interactive::reactions_to(scene, forces);
    // The work of both along a motion of the constrained nodes is the same.
    const Field targets = noise(static_cast<Eigen::Index>(scene.constrained_nodes.size()), 1.0, 6);
    Field moved = Field::Zero(3, forces.cols());
    interactive::put_constrained(scene, targets, moved);
    EXPECT_NEAR(pushed.cwiseProduct(targets).sum(), -forces.cwiseProduct(moved).sum(), 1e-12);
    EXPECT_GT(scene.followers.size(), 0U);
}

} // namespace
} // namespace livermark
