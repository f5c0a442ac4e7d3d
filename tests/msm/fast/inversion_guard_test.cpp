#include <algorithm>
#include <gtest/gtest.h>

#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/integrator.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/spring_network.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

/// A box constrained at one side, and pressed on the other by a fourth of its Young's modulus.
struct PressedBox {
    std::shared_ptr<const core::Body> body =
        tests::make_body(tests::shaken_box_mesh({0.1, 0.1, 0.1}, {3, 3, 3}), {1060.0, 5e3, 0.45});
    core::SpringNetwork springs = msm::spring_network(*body, msm::all_spring_laws().front());
    msm::NodalConditions conditions = [this] {
        auto load_case = tests::empty_load_case(body->mesh);
        tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
        tests::pull(load_case, body->mesh, "x_max", {-1250.0, 0.0, 0.0});
        return msm::nodal_conditions({body, load_case}, springs.node_mass);
    }();

    /// Of all tetrahedra, after the load has long been on, with much damping [m^3].
    double smallest_volume_at_rest(const msm::ElasticBody &elastic) const {
        const double highest = msm::largest_angular_frequency(elastic, body->mesh.points, conditions);
        const auto equation = msm::elastic_motion(elastic, body->mesh.points, conditions, {0.2 * highest, 0.0});
        const auto step = msm::find_integrator("symplectic_euler").prepare(equation, 0.3 / highest);
        const Eigen::VectorXd zero = Eigen::VectorXd::Zero(3 * body->mesh.num_nodes());
        msm::State state{zero, zero};
        for (int s = 0; s < 20000; ++s)
            step(state);
        EXPECT_LT(msm::kinetic_energy(equation, state), 1e-12);
        auto moved = body->mesh;
        for (int i = 0; i < moved.num_nodes(); ++i)
            moved.points[i] += msm::of_node(state.displacement, i);
        return std::ranges::min(core::tetrahedron_volumes(moved));
    }
};

/// Pressed together by a fifth or more, springs give way through their own mirror image, and the volume around a node
/// may stay what it was with a tetrahedron there inside out. The guard holds up to twice that load.
TEST(InversionGuard, HoldsTetrahedraThatSpringsLetTurnInsideOut) {
    const PressedBox box;
    const auto springs = msm::spring_term(box.springs);
    const auto resists = msm::all_volume_terms().front().make(*box.body, {8e3});
    const msm::ElasticBody unguarded(box.springs.node_mass, {springs, resists});
    const msm::ElasticBody guarded(box.springs.node_mass, {springs, resists, msm::inversion_guard(*box.body)});
    EXPECT_LT(box.smallest_volume_at_rest(unguarded), 0.0);
    EXPECT_GT(box.smallest_volume_at_rest(guarded), 0.0);
}

TEST(InversionGuard, IsNotFeltAsLongAsTetrahedraKeepHalfTheirVolume) {
    const PressedBox box;
    const auto guard = msm::inversion_guard(*box.body);
    auto squeezed = box.body->mesh.points;
    for (auto &x : squeezed)
        x.z() *= 0.51;
    EXPECT_EQ(guard->energy(msm::to_unknowns(squeezed)), 0.0);
    for (auto &x : squeezed)
        x.z() *= 0.9;
    EXPECT_GT(guard->energy(msm::to_unknowns(squeezed)), 0.0);
}

} // namespace
} // namespace livermark
