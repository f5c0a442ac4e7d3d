#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <memory>
#include <set>
#include <string>
#include <tuple>

#include "interactive/elements/quadratic_tetrahedra.hpp"
#include "interactive/kernels/fans.hpp"
#include "interactive/method.hpp"
#include "tests/interactive/moving_scene.hpp"
#include "tests/oracles/equilibria.hpp"
#include "tests/oracles/slow_methods.hpp"

namespace livermark {
namespace {

using core::Vector3;
using interactive::Field;
using interactive::Scene;
using tests::bar_scene;
using tests::noise;
using tests::scenes_of_any_padding;
using tests::uneven_scene;

/// The forces behind a step from rest at a shape.
Field forces_of_step(const interactive::Method &method, const Scene &scene, const Field &x) {
    const double h = 1e-4;
    const auto simulation = method.prepare(scene);
    simulation->set_state(x, Field::Zero(3, x.cols()));
    simulation->step(h, 1);
    Field forces = simulation->velocities() / h;
    for (Eigen::Index i = 0; i < forces.cols(); ++i)
        forces.col(i) *= simulation->scene().node_mass[i];
    return forces;
}

/// Those of a method's own are among them.
Field rest_of(const interactive::Method &method, const Scene &scene) {
    return method.prepare(scene)->positions();
}

Field forces_of_energy(const interactive::Method &method, const Scene &scene, const Field &x) {
    const auto simulation = method.prepare(scene);
    simulation->set_state(x, Field::Zero(3, x.cols()));
    return simulation->elastic_forces();
}

double relative(const Field &found, const Field &expected) {
    return (found - expected).norm() / expected.norm();
}

struct ExplicitTetrahedraMethod : testing::TestWithParam<const char *> {
    const interactive::Method &method = interactive::find_method(GetParam());
};

TEST_P(ExplicitTetrahedraMethod, HasTheForcesOfItsEnergyInSinglePrecision) {
    for (const auto &scene : scenes_of_any_padding()) {
        const Field rest = rest_of(method, scene);
        // Displacements that single precision has exactly.
        const Field u = noise(rest.cols(), 1e-3, 1).cast<float>().cast<double>();
        const Field expected = forces_of_energy(method, scene, rest + u);
        ASSERT_GT(expected.norm(), 0.01);
        EXPECT_LT(relative(forces_of_step(method, scene, rest + u), expected), 2e-6) << rest.cols();
    }
}

TEST_P(ExplicitTetrahedraMethod, KeepsTheDigitsOfForcesWhereStrainsAreSmall) {
    for (const auto &scene : scenes_of_any_padding()) {
        const Field rest = rest_of(method, scene);
        const Field u = noise(rest.cols(), 1e-8, 1).cast<float>().cast<double>();
        const Field expected = forces_of_energy(method, scene, rest + u);
        EXPECT_LT(relative(forces_of_step(method, scene, rest + u), expected), 1e-5) << rest.cols();
    }
}

TEST_P(ExplicitTetrahedraMethod, HasNextToNoForcesWhereTheBodyIsTurned) {
    const auto scene = bar_scene(false);
    const Field rest = rest_of(method, scene);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(2.0, Vector3(1.0, -2.0, 0.5).normalized()).matrix();
    const double turned = forces_of_step(method, scene, turn * rest).norm();
    const double stretched = forces_of_step(method, scene, 1.1 * rest).norm();
    EXPECT_LT(turned, 1e-4 * stretched);
    EXPECT_GT(stretched, 0.0);
}

/// The moves of a tool and of a frame, with external forces: more than a centimetre.
void move_on(interactive::Simulation &simulation) {
    simulation.set_external_forces(Vector3(1e-3, 0.0, -4e-3).replicate(1, simulation.scene().body->mesh.num_nodes()));
    const Field start = simulation.targets();
    const double h = 0.8 * simulation.critical_time_step();
    for (int frame = 1; frame <= 60; ++frame) {
        const double way = std::min(frame, 30) / 30.0;
        simulation.set_targets(start.colwise() + way * Vector3(2e-3, 4e-3, -1e-2));
        simulation.step(20.0 * h, 20);
    }
}

TEST_P(ExplicitTetrahedraMethod, MovesAsInDoublePrecision) {
    for (const bool is_constrained : {true, false}) {
        const auto scene = uneven_scene({5, 3, 3}, is_constrained, 5.0);
        const Field rest = rest_of(method, scene);
        const auto fast = method.prepare(scene), slow = tests::prepare_slowly(method, scene);
        for (const auto *simulation : {&fast, &slow}) {
            (*simulation)->set_state(rest, noise(rest.cols(), 0.02, 5));
            move_on(**simulation);
        }
        const double motion = (slow->positions() - rest).norm();
        EXPECT_GT(motion / std::sqrt(rest.cols()), 0.01);
        EXPECT_LT((fast->positions() - slow->positions()).norm(), 1e-4 * motion) << is_constrained;
        EXPECT_GT((fast->positions() - slow->positions()).norm(), 0.0) << "both are the same code";
    }
}

TEST_P(ExplicitTetrahedraMethod, ComesToTheEquilibriumOfItsEnergy) {
    const auto simulation = method.prepare(bar_scene(true, 0.45, 20.0));
    simulation->set_external_forces(Vector3(1e-3, 0.0, -8e-3).replicate(1, simulation->positions().cols()));
    const auto expected = tests::equilibrium(*simulation);
    ASSERT_TRUE(expected.converged);
    const double h = 0.8 * simulation->critical_time_step();
    for (int i = 0; i < 40; ++i)
        simulation->step(100.0 * h, 100);
    const double size = (expected.positions - interactive::rest_positions(simulation->scene())).norm();
    EXPECT_LT((simulation->positions() - expected.positions).norm(), 1e-4 * size);
}

TEST_P(ExplicitTetrahedraMethod, StaysAtRestToTheLastBit) {
    const auto simulation = method.prepare(uneven_scene({3, 2, 1}, true));
    const Field rest = simulation->positions();
    for (int i = 0; i < 5; ++i)
        simulation->step(2e-3, 20);
    EXPECT_EQ(simulation->positions(), rest);
    EXPECT_EQ(simulation->velocities(), Field::Zero(3, rest.cols()));
}

TEST_P(ExplicitTetrahedraMethod, FliesAndConservesMomentum) {
    const auto scene = uneven_scene({3, 2, 1}, false);
    const auto simulation = method.prepare(scene);
    const Field rest = simulation->positions();
    const auto momentum = [&] {
        Vector3 sum = Vector3::Zero();
        for (Eigen::Index i = 0; i < rest.cols(); ++i)
            sum += simulation->scene().node_mass[i] * simulation->velocities().col(i);
        return sum;
    };
    const Vector3 velocity(0.3, -0.2, 0.1);
    simulation->set_state(rest, velocity.replicate(1, rest.cols()) + noise(rest.cols(), 0.05, 3));
    const Vector3 before = momentum();
    const double h = 0.5 * simulation->critical_time_step();
    for (int i = 0; i < 10; ++i)
        simulation->step(20.0 * h, 20);
    EXPECT_LT((momentum() - before).norm(), 1e-5 * before.norm());
    EXPECT_GT(simulation->elastic_forces().norm(), 0.01); // it did deform
    EXPECT_GT((simulation->positions() - rest).norm(), 100.0 * h * velocity.norm() * std::sqrt(rest.cols()));
}

TEST_P(ExplicitTetrahedraMethod, PutsConstrainedNodesExactlyWhereTheyAreToldToBe) {
    const auto simulation = method.prepare(uneven_scene({3, 2, 1}, true));
    for (int i = 1; i <= 3; ++i) {
        const Field targets = simulation->targets().colwise() + Vector3(-1e-3, 5e-4, 1e-4 / 3.0);
        simulation->set_targets(targets);
        simulation->step(2e-3, 20);
        for (Eigen::Index c = 0; c < targets.cols(); ++c)
            EXPECT_EQ(simulation->positions().col(simulation->scene().constrained_nodes[c]), targets.col(c));
    }
    EXPECT_LT(simulation->reactions().row(0).sum(), -0.01); // it is pulled there
}

TEST_P(ExplicitTetrahedraMethod, HasNoNumbersWhereTetrahedraAreInsideOut) {
    const auto scene = uneven_scene({1, 1, 1}, false);
    Field x = rest_of(method, scene);
    x.row(2) *= -1.0;
    EXPECT_TRUE(forces_of_step(method, scene, x).hasNaN());
}

TEST_P(ExplicitTetrahedraMethod, SaysWhatItReads) {
    const auto simulation = method.prepare(uneven_scene({5, 3, 3}, false));
    const auto &scene = simulation->scene();
    const auto num_tetrahedra = static_cast<double>(scene.body->mesh.num_tetrahedra());
    const auto num_nodes = static_cast<double>(simulation->positions().cols());
    const std::size_t element =
        scene.own_nodes.empty() ? sizeof(interactive::Tetrahedron) : sizeof(interactive::QuadraticTetrahedron);
    // Positions, velocities and external forces, and a mass.
    const double in_double = static_cast<double>(element) + 10 * sizeof(double) * num_nodes / num_tetrahedra;
    const auto cost = simulation->cost(7);
    EXPECT_EQ(cost.element_passes, 7.0 * (method.name == "tled_nodal_pressure" ? 2.0 : 1.0));
    EXPECT_GT(cost.bytes_per_element, 44.0); // gradients and moduli alone
    EXPECT_LT(cost.bytes_per_element, 2.0 * in_double);
}

INSTANTIATE_TEST_SUITE_P(All, ExplicitTetrahedraMethod,
                         testing::Values("tled", "tled_nodal_pressure", "tled_quadratic"));

using MethodAndTarget = std::tuple<const char *, std::int64_t>;

struct VectorUnit : testing::TestWithParam<MethodAndTarget> {
    tests::ChosenVectorUnit unit{std::get<1>(GetParam())};
};

TEST_P(VectorUnit, HasTheForcesAndTheStepsOfTheOthers) {
    const auto &method = interactive::find_method(std::get<0>(GetParam()));
    const auto scene = uneven_scene({5, 3, 3}, true, 5.0);
    const Field rest = rest_of(method, scene);
    const auto after_steps = [&] {
        const auto simulation = method.prepare(scene);
        simulation->set_state(rest, noise(rest.cols(), 0.05, 5));
        simulation->step(5e-3, 60);
        return simulation->positions();
    };
    const Field found = after_steps();
    tests::ChosenVectorUnit::choose(0);
    const Field expected = after_steps();
    EXPECT_LT((found - expected).norm(), 1e-5 * (expected - rest).norm());
    const bool multiplies_and_adds_at_once = (std::get<1>(GetParam()) & (HWY_SCALAR | HWY_SSSE3 | HWY_SSE4)) == 0;
    if (multiplies_and_adds_at_once) {
        EXPECT_EQ(found, expected);
    }
    EXPECT_EQ(after_steps(), expected);
}

std::string name_of_method_and_unit(const testing::TestParamInfo<MethodAndTarget> &info) {
    return std::string(std::get<0>(info.param)) + "_" + hwy::TargetName(std::get<1>(info.param));
}

INSTANTIATE_TEST_SUITE_P(All, VectorUnit,
                         testing::Combine(testing::Values("tled", "tled_nodal_pressure", "tled_quadratic"),
                                          testing::ValuesIn(hwy::SupportedAndGeneratedTargets())),
                         name_of_method_and_unit);

TEST(Fans, HaveEachTetrahedronOnceAndGoFromFaceToFace) {
    const auto mesh = tests::box_mesh({0.06, 0.03, 0.03}, {5, 3, 3});
    const auto fans = interactive::kernels::cut_into_fans(mesh.tetrahedra);
    std::set<int> seen;
    for (const auto &[axis, rim, tetrahedra] : fans) {
        ASSERT_EQ(rim.size(), tetrahedra.size() + 1);
        for (std::size_t k = 0; k < tetrahedra.size(); ++k) {
            EXPECT_TRUE(seen.insert(tetrahedra[k]).second);
            std::set<int> expected{axis[0], axis[1], rim[k], rim[k + 1]};
            const auto &nodes = mesh.tetrahedra[tetrahedra[k]];
            EXPECT_EQ(std::set<int>(nodes.begin(), nodes.end()), expected);
        }
    }
    EXPECT_EQ(seen.size(), mesh.tetrahedra.size());
    EXPECT_LT(fans.size(), mesh.tetrahedra.size() / 3); // so that they are worth it
}

} // namespace
} // namespace livermark
