#pragma once

#include <algorithm>
#include <array>
#include <gtest/gtest.h>

#include "interactive/method.hpp"
#include "tests/interactive/moving_scene.hpp"
#include "tests/oracles/slow_methods.hpp"

namespace livermark::tests {

/// Steps and iterations of 1/60 s.
struct Frames {
    int steps, iterations;
};

/// More than a centimetre in 20 frames, with a tool and external forces.
inline void drag(interactive::Simulation &simulation, const Frames &frames) {
    const interactive::Field start = simulation.targets();
    simulation.set_external_forces(
        core::Vector3(1e-3, 0.0, -4e-3).replicate(1, simulation.scene().body->mesh.num_nodes()));
    simulation.set_state(simulation.positions(), noise(simulation.positions().cols(), 0.05, 5));
    for (int step = 1; step <= 20 * frames.steps; ++step) {
        const double way = std::min(1.0, step / (15.0 * frames.steps));
        simulation.set_targets(start.colwise() + way * core::Vector3(2e-3, 4e-3, -1e-2));
        simulation.step(interactive::frame_time / frames.steps, frames.iterations);
    }
}

/// Where a drag ends, with single precision first.
inline std::array<std::unique_ptr<interactive::Simulation>, 2>
dragged_in_both(const interactive::Method &method, const interactive::Scene &scene, const Frames &frames) {
    std::array<std::unique_ptr<interactive::Simulation>, 2> ends{method.prepare(scene), prepare_slowly(method, scene)};
    for (const auto &end : ends)
        drag(*end, frames);
    return ends;
}

/// Between the positions of both after a drag, over how far it went.
inline double distance_over_motion(const interactive::Method &method, const interactive::Scene &scene,
                                   const Frames &frames) {
    const auto [single, in_double] = dragged_in_both(method, scene, frames);
    const double motion = (in_double->positions() - interactive::rest_positions(scene)).norm();
    EXPECT_GT(motion, 0.01);
    return (single->positions() - in_double->positions()).norm() / motion;
}

/// Between the bits of a drag on each kind of vectors and those of the best one: none where they multiply and add at
/// once.
inline void expect_the_same_on_any_vectors(const interactive::Method &method, const Frames &frames, double tolerance) {
    const auto scene = uneven_scene({5, 3, 3}, true, 5.0);
    const auto end_on = [&](std::int64_t target) {
        const ChosenVectorUnit unit(target);
        const auto simulation = method.prepare(scene);
        drag(*simulation, frames);
        return simulation->positions();
    };
    const interactive::Field expected = end_on(0);
    const double motion = (expected - interactive::rest_positions(scene)).norm();
    for (const auto target : hwy::SupportedAndGeneratedTargets()) {
        const interactive::Field found = end_on(target);
        EXPECT_LT((found - expected).norm(), tolerance * motion) << hwy::TargetName(target);
        if ((target & (HWY_SCALAR | HWY_SSSE3 | HWY_SSE4)) == 0) {
            EXPECT_EQ(found, expected) << hwy::TargetName(target);
        }
    }
}

inline core::Vector3 momentum_of(const interactive::Simulation &simulation) {
    core::Vector3 sum = core::Vector3::Zero();
    for (Eigen::Index i = 0; i < simulation.velocities().cols(); ++i)
        sum += simulation.scene().node_mass[i] * simulation.velocities().col(i);
    return sum;
}

/// Lets a free bar that turns and quivers move for ten steps of 2 ms: it keeps its momentum.
inline void expect_momentum_to_stay(const interactive::Method &method, int iterations, double tolerance) {
    const auto simulation = method.prepare(uneven_scene({3, 2, 1}, false));
    const auto num_nodes = simulation->positions().cols();
    simulation->set_state(simulation->positions(),
                          core::Vector3(0.3, -0.2, 0.1).replicate(1, num_nodes) + noise(num_nodes, 0.1, 3));
    const core::Vector3 before = momentum_of(*simulation);
    for (int i = 0; i < 10; ++i)
        simulation->step(2e-3, iterations);
    EXPECT_LT((momentum_of(*simulation) - before).norm(), tolerance * before.norm());
    EXPECT_GT(simulation->elastic_forces().norm(), 0.01); // it did deform
}

/// Moves the constrained nodes of a bar aside in one step: they are where they are told to be to the last bit.
inline void expect_constrained_nodes_at_targets(const interactive::Method &method) {
    const auto simulation = method.prepare(uneven_scene({3, 2, 1}, true));
    const interactive::Field targets = simulation->targets().colwise() + core::Vector3(-1e-3, 5e-4, 1e-4 / 3.0);
    simulation->set_targets(targets);
    simulation->step(2e-3, 20);
    for (Eigen::Index c = 0; c < targets.cols(); ++c)
        EXPECT_EQ(simulation->positions().col(simulation->scene().constrained_nodes[c]), targets.col(c));
    EXPECT_LT(simulation->reactions().row(0).sum(), -0.01); // it is pulled there
}

} // namespace livermark::tests
