#pragma once

#include <algorithm>
#include <array>
#include <gtest/gtest.h>

#include "interactive/method.hpp"
#include "tests/interactive/moving_scene.hpp"

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
    std::array<std::unique_ptr<interactive::Simulation>, 2> ends;
    for (const auto precision : {interactive::Precision::single_precision, interactive::Precision::double_precision}) {
        auto &end = ends[precision == interactive::Precision::double_precision];
        end = method.prepare(in_precision(scene, precision));
        drag(*end, frames);
    }
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

} // namespace livermark::tests
