#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "core/mesh/places.hpp"
#include "interactive/equilibrium.hpp"
#include "interactive/method.hpp"
#include "tests/interactive/moving_scene.hpp"
#include "tests/oracles/slow_methods.hpp"

namespace livermark::interactive {
namespace {

/// An action after each step gives nodes what a force in the step gives them.
TEST(ActionsAfterSteps, ActAsForcesInTheSteps) {
    constexpr double pull = 2e-3;
    for (const std::string name : {"tled", "tled_nodal_pressure"}) {
        SCOPED_TRACE(name);
        const auto &method = find_method(name);
        const auto scene = tests::uneven_scene({3, 2, 1}, true);
        const auto by_action = method.prepare(scene), by_force = method.prepare(scene);
        const int node = scene.body->mesh.num_nodes() - 1;
        Field force = Field::Zero(3, scene.body->mesh.num_nodes());
        force(2, node) = pull;
        by_force->set_external_forces(force);
        int calls = 0;
        ASSERT_TRUE(by_action->act_after_steps([&](core::MovingNodes &nodes, double part, double h) {
            ++calls;
            EXPECT_NEAR(part, ((calls - 1) % 50 + 1) / 50.0, 1e-12);
            core::Vector3 before, after;
            nodes.displacements(std::vector{node}, {&before, 1});
            const core::Vector3 change(0.0, 0.0, h * pull / scene.node_mass[node]);
            nodes.kick(std::vector{node}, {&change, 1}, h);
            nodes.displacements(std::vector{node}, {&after, 1});
            EXPECT_NEAR((after - before).z(), h * change.z(), 1e-8);
        }));
        for (int frame = 0; frame < 4; ++frame)
            for (const auto *simulation : {&by_action, &by_force})
                (*simulation)->step(frame_time, 50);
        EXPECT_EQ(calls, 200);
        const double way = (by_force->positions().col(node) - rest_positions(scene).col(node)).norm();
        EXPECT_GT(way, 1e-4);
        EXPECT_LT((by_action->positions() - by_force->positions()).norm(), 2e-3 * way);
    }
}

TEST(ActionsAfterSteps, AreNoneOfImplicitMethods) {
    for (const auto &method : all_methods()) {
        const auto simulation = method.prepare(tests::uneven_scene({1, 1, 1}, true));
        EXPECT_EQ(simulation->act_after_steps([](core::MovingNodes &, double, double) {}), method.is_explicit)
            << method.name;
    }
}

/// A kick leaves positions and velocities as if they had been set, in every method.
TEST(Kicks, MoveNodesOnByAStep) {
    for (const auto &method : all_methods()) {
        SCOPED_TRACE(method.name);
        const auto simulation = method.prepare(tests::uneven_scene({3, 2, 1}, true));
        for (int step = 0; step < 3; ++step)
            simulation->step(frame_time, method.iterations * (method.is_explicit ? 4 : 1));
        const Field positions = simulation->positions(), velocities = simulation->velocities();
        Field change = tests::noise(positions.cols(), 0.05, 3);
        for (Eigen::Index i = 0; i < change.cols(); ++i)
            if (!free_nodes(simulation->scene())[i])
                change.col(i).setZero();
        simulation->kick(change, frame_time);
        EXPECT_LT((simulation->positions() - positions - frame_time * change).norm(), 1e-6);
        EXPECT_LT((simulation->velocities() - velocities - change).norm(), 1e-5);
        EXPECT_LT(simulation->elastic_forces().norm(), 1e3);
    }
}

/// A small impulse on a place, in a step that has come to its end.
TEST(PlaceResponse, IsWhatAConvergedStepDoes) {
    const auto scene = tests::bar_scene(true, 0.45, 5.0);
    const auto simulation = tests::slow_method("corotational_implicit").prepare(scene);
    const std::vector<core::InteriorPlace> places{{{0.04, 0.015, 0.015}, 0.012}, {{0.05, 0.012, 0.02}, 0.012}};
    const auto weights = core::nodal_weights(places, scene.body->mesh);
    const Eigen::MatrixXf response = place_response(*simulation, frame_time, weights);
    ASSERT_EQ(response.rows(), 3 * scene.body->mesh.num_nodes());
    ASSERT_EQ(response.cols(), 6);
    constexpr double impulse = 1e-7;
    Field forces = Field::Zero(3, scene.body->mesh.num_nodes());
    for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(weights, 1); entry; ++entry)
        forces(2, entry.col()) = impulse / frame_time * entry.value();
    simulation->set_external_forces(forces);
    simulation->step(frame_time, 400);
    const Eigen::VectorXd expected = impulse * response.col(5).cast<double>();
    const Eigen::Map<const Eigen::VectorXd> found(simulation->velocities().data(), expected.size());
    EXPECT_GT(expected.norm(), 0.0);
    EXPECT_LT((found - expected).norm(), 1e-3 * expected.norm());
}

/// Steps that converge are observed to respond as backward Euler, and those that do not give way farther.
TEST(PlaceResponse, IsObservedInStepsOfAMethod) {
    const auto scene = tests::bar_scene(true, 0.45, 5.0);
    const std::vector<core::InteriorPlace> places{{{0.04, 0.015, 0.015}, 0.012}, {{0.05, 0.012, 0.02}, 0.012}};
    const auto weights = core::nodal_weights(places, scene.body->mesh);
    constexpr double force = 6e-6;
    const auto simulation = tests::slow_method("corotational_implicit").prepare(scene);
    const Eigen::MatrixXf expected = place_response(*simulation, frame_time, weights);
    const auto observed = [&](const std::string &name, int iterations) {
        return observed_place_response(*tests::slow_method(name).prepare(scene), frame_time, 1, iterations, weights,
                                       force);
    };
    EXPECT_LT((observed("corotational_implicit", 400) - expected).norm(), 1e-3 * expected.norm());
    EXPECT_GT(observed("projective_dynamics", 1).norm(), 1.2 * expected.norm());
}

} // namespace
} // namespace livermark::interactive
