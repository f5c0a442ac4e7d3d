#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>
#include <string>

#include "interactive/equilibrium.hpp"
#include "interactive/method.hpp"
#include "tests/interactive/moving_scene.hpp"
#include "tests/oracles/equilibria.hpp"
#include "tests/oracles/slow_methods.hpp"

namespace livermark {
namespace {

using core::Vector3;
using interactive::Field;
using tests::bar_scene;
using tests::noise;
using tests::turned;

constexpr double time_step = 2e-3;

/// Over every method of the table, with its steps in double precision.
struct InteractiveMethod : testing::TestWithParam<std::string> {
    const interactive::Method method = tests::slow_method(GetParam());
};

TEST_P(InteractiveMethod, HasAnEnergyWhoseDerivativesAreItsForces) {
    const auto simulation = method.prepare(bar_scene(false));
    const auto &energy = simulation->energy();
    const Field x = turned(simulation->positions()) + noise(simulation->positions().cols(), 1e-3, 1);
    Field forces = Field::Zero(3, x.cols());
    energy.add_forces(x, forces);
    for (unsigned seed = 2; seed < 6; ++seed) {
        const Field way = noise(x.cols(), 1e-6, seed);
        const double difference = energy.value(x + way) - energy.value(x - way);
        EXPECT_NEAR(difference, -2.0 * forces.cwiseProduct(way).sum(), 1e-5 * std::abs(difference));
    }
}

TEST_P(InteractiveMethod, HasForcesWhoseDerivativesAreItsHessian) {
    const auto simulation = method.prepare(bar_scene(false));
    const auto &energy = simulation->energy();
    const Field x = turned(simulation->positions()) + noise(simulation->positions().cols(), 1e-3, 1);
    interactive::Energy::Triplets triplets;
    energy.add_hessian(x, false, triplets);
    for (unsigned seed = 2; seed < 4; ++seed) {
        const Field way = noise(x.cols(), 1e-7, seed);
        Field difference = Field::Zero(3, x.cols()), product = difference;
        energy.add_forces(x - way, difference);
        difference *= -1.0;
        energy.add_forces(x + way, difference);
        for (const auto &entry : triplets)
            product.data()[entry.row()] -= 2.0 * entry.value() * way.data()[entry.col()];
        EXPECT_LT((difference - product).norm(), 1e-5 * product.norm());
    }
}

TEST_P(InteractiveMethod, HasNoForcesWhereTheBodyIsMovedRigidly) {
    const auto simulation = method.prepare(bar_scene(false));
    const Field rest = simulation->positions();
    Field moved = Field::Zero(3, rest.cols()), stretched = moved;
    simulation->energy().add_forces(turned(rest), moved);
    simulation->energy().add_forces(1.01 * rest, stretched);
    EXPECT_LT(moved.norm(), 1e-9 * stretched.norm());
    EXPECT_GT(stretched.norm(), 0.0);
}

TEST_P(InteractiveMethod, StaysAtRestWhereNothingMovesIt) {
    const auto simulation = method.prepare(bar_scene(true));
    const Field rest = simulation->positions();
    for (int i = 0; i < 5; ++i)
        simulation->step(time_step, 10);
    EXPECT_LT((simulation->positions() - rest).norm(), 1e-12);
    EXPECT_LT(simulation->reactions().norm(), 1e-8);
}

TEST_P(InteractiveMethod, FliesAsARigidBodyDoes) {
    const auto simulation = method.prepare(bar_scene(false));
    const Field start = turned(simulation->positions());
    const Vector3 velocity(0.3, -0.2, 0.1);
    simulation->set_state(start, velocity.replicate(1, start.cols()));
    for (int i = 0; i < 10; ++i)
        simulation->step(time_step, 20);
    EXPECT_LT((simulation->positions() - (start.colwise() + 10 * time_step * velocity)).norm(), 1e-9 * start.norm());
}

TEST_P(InteractiveMethod, ConservesMomentumOnceItsIterationsHaveConverged) {
    const auto simulation = method.prepare(bar_scene(false));
    simulation->set_state(simulation->positions(), noise(simulation->positions().cols(), 0.2, 3));
    const Vector3 before = tests::momentum_of(*simulation);
    const int iterations = method.is_explicit ? 40 : 4000; // more would change nothing
    for (int i = 0; i < 3; ++i)
        simulation->step(time_step, iterations);
    EXPECT_LT((tests::momentum_of(*simulation) - before).norm(), 1e-7 * before.norm());
    EXPECT_GT(simulation->elastic_forces().norm(), 0.01); // it did deform
}

TEST_P(InteractiveMethod, PutsConstrainedNodesWhereTheyAreToldToBe) {
    const auto simulation = method.prepare(bar_scene(true));
    const Field targets = simulation->targets().colwise() + Vector3(-1e-3, 5e-4, 0.0);
    simulation->set_targets(targets);
    simulation->step(time_step, 20);
    for (Eigen::Index c = 0; c < targets.cols(); ++c)
        EXPECT_EQ(simulation->positions().col(simulation->scene().constrained_nodes[c]), targets.col(c));
    EXPECT_LT(simulation->reactions().row(0).sum(), -0.01); // it is pulled there
}

TEST_P(InteractiveMethod, TakesTheSameStepsToTheLastBit) {
    const auto &fast = interactive::find_method(GetParam());
    const auto one = fast.prepare(bar_scene(true)), two = fast.prepare(bar_scene(true));
    for (const auto *simulation : {&one, &two}) {
        (*simulation)->set_external_forces(noise((*simulation)->positions().cols(), 1e-2, 7));
        for (int i = 0; i < 5; ++i)
            (*simulation)->step(time_step, 20);
    }
    EXPECT_EQ(one->positions(), two->positions());
}

TEST_P(InteractiveMethod, RestsWhereReactionsCarryTheExternalForces) {
    const auto simulation = method.prepare(bar_scene(true));
    const Field forces = Vector3(0.0, 0.0, -1e-3).replicate(1, simulation->positions().cols());
    simulation->set_external_forces(forces);
    const auto rest = tests::equilibrium(*simulation);
    ASSERT_TRUE(rest.converged);
    simulation->set_state(rest.positions, Field::Zero(3, forces.cols()));
    const Vector3 total = simulation->reactions().rowwise().sum();
    EXPECT_NEAR(total.z(), 1e-3 * static_cast<double>(forces.cols()), 1e-8);
    EXPECT_LT(rest.positions.row(2).minCoeff(), -1e-4); // it did sag
}

/// A press to a depth is a load: the one that it reports.
TEST_P(InteractiveMethod, RestsAtADepthUnderTheForceThatMovesAsFar) {
    const auto simulation = method.prepare(bar_scene(true));
    const Field rest = interactive::rest_positions(simulation->scene());
    Field one_newton = Field::Zero(3, rest.cols());
    for (Eigen::Index i = 0; i < rest.cols(); ++i)
        if (rest(0, i) == rest.row(0).maxCoeff())
            one_newton.col(i) = Vector3(0.3, 0.0, -1.0);
    one_newton /= one_newton.rowwise().sum().norm();
    simulation->set_external_forces(one_newton);
    constexpr double depth = 0.01;
    const auto pressed = interactive::equilibria(*simulation, {0.5, 1.0}, 1e-9, depth);
    ASSERT_EQ(pressed.size(), 2U);
    for (const auto &state : pressed) {
        ASSERT_TRUE(state.converged);
        EXPECT_NEAR(one_newton.cwiseProduct(state.positions - rest).sum(), state.fraction * depth, 1e-9 * depth);
        simulation->set_external_forces(state.load * one_newton);
        const auto loaded = tests::equilibrium(*simulation);
        ASSERT_TRUE(loaded.converged);
        EXPECT_LT((state.positions - loaded.positions).norm(), 1e-6 * (loaded.positions - rest).norm());
    }
    EXPECT_GT(pressed[1].load, 1.5 * pressed[0].load);
}

INSTANTIATE_TEST_SUITE_P(All, InteractiveMethod, testing::ValuesIn(tests::method_names()),
                         [](const auto &of) { return of.param; });

TEST(Scene, WithoutAMassForEachNodeOrWithANodeConstrainedTwiceIsRefused) {
    auto light = bar_scene(true), twice = light;
    light.node_mass.pop_back();
    twice.constrained_nodes.push_back(twice.constrained_nodes.front());
    for (const auto &scene : {light, twice})
        EXPECT_THROW(interactive::find_method("corotational_implicit").prepare(scene), std::invalid_argument);
}

TEST(Method, IsNotFoundUnderAnotherName) {
    EXPECT_THROW(interactive::find_method("nothing"), std::invalid_argument);
}

} // namespace
} // namespace livermark
