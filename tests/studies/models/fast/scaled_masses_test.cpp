#include "studies/models/motion/moving_method.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "interactive/method.hpp"
#include "msm/elastic_body.hpp"
#include "tests/oracles/equilibria.hpp"
#include "tests/oracles/slow_methods.hpp"
#include "tests/samples/moving_samples.hpp"

namespace livermark {
namespace {

using core::Vector3;
using interactive::Scene;

/// A soft bar with a lump in its middle, free or with its end at x = 0 constrained.
Scene lumpy_bar(double hardness, bool is_constrained, double mass_damping = 0.0) {
    Scene scene{.body = std::make_shared<const core::Body>(tests::lumpy_bar({6, 2, 2}, hardness)),
                .node_mass = {},
                .constrained_nodes = {},
                .mass_damping = mass_damping};
    scene.node_mass = msm::lumped_masses(*scene.body);
    for (int i = 0; is_constrained && i < scene.body->mesh.num_nodes(); ++i)
        if (scene.body->mesh.points[i].x() == 0.0)
            scene.constrained_nodes.push_back(i);
    return scene;
}

constexpr double hardness = 30.0;

struct ScaledExplicitMethod : testing::TestWithParam<const char *> {
    const interactive::Method &method = interactive::find_method(GetParam());
    const interactive::Method slow = tests::slow_method(GetParam()); ///< in double precision

    /// With its masses scaled.
    static std::unique_ptr<interactive::Simulation> prepare(const interactive::Method &method, const Scene &scene) {
        auto simulation = method.prepare(scene);
        EXPECT_TRUE(simulation->correct_steps(models::correction_of(models::scale_masses(*simulation))));
        return simulation;
    }
};

TEST_P(ScaledExplicitMethod, BearsTheStepsOfTheSoftTissue) {
    const auto hard = method.prepare(lumpy_bar(hardness, true));
    const auto soft = method.prepare(lumpy_bar(1.0, true));
    const auto scaling = models::scale_masses(*hard);
    ASSERT_EQ(scaling.parts.size(), 1U);
    EXPECT_GT(scaling.parts[0].factor, 10.0);
    const double scaled = models::critical_time_step(*hard, scaling);
    EXPECT_LT(hard->critical_time_step(), 0.3 * soft->critical_time_step());
    EXPECT_GT(scaled, 0.8 * soft->critical_time_step());
}

TEST_P(ScaledExplicitMethod, KnowsItsCriticalTimeStep) {
    for (const auto *moved_by : {&method, &slow})
        for (const auto &[factor, is_stable] : {std::pair(0.95, true), std::pair(1.06, false)}) {
            const auto simulation = prepare(*moved_by, lumpy_bar(hardness, true));
            const double h = factor * models::critical_time_step(*simulation, models::scale_masses(*simulation));
            interactive::Field x = simulation->positions();
            for (Eigen::Index i = 0; i < x.cols(); ++i)
                x(2, i) += 1e-6 * std::sin(1e4 * x(0, i) + 3e4 * x(1, i)); // of any shape
            simulation->set_state(x, interactive::Field::Zero(3, x.cols()));
            for (int i = 0; i < 20; ++i)
                simulation->step(100.0 * h, 100);
            const auto &v = simulation->velocities();
            EXPECT_EQ(v.allFinite() && v.norm() < 1e-2, is_stable) << factor;
        }
}

TEST_P(ScaledExplicitMethod, ConservesBothMomenta) {
    const auto simulation = prepare(slow, lumpy_bar(hardness, false));
    const auto momenta = [&] {
        Eigen::Matrix<double, 3, 2> sum = Eigen::Matrix<double, 3, 2>::Zero();
        const double h = 1e-4; // velocities are half a step behind
        for (Eigen::Index i = 0; i < simulation->velocities().cols(); ++i) {
            const Vector3 v = simulation->velocities().col(i);
            const double mass = simulation->scene().node_mass[i];
            sum.col(0) += mass * v;
            sum.col(1) += mass * Vector3(simulation->positions().col(i) - 0.5 * h * v).cross(v);
        }
        return sum;
    };
    interactive::Field x = simulation->positions(), v = x;
    for (Eigen::Index i = 0; i < x.cols(); ++i) {
        v.col(i) = Vector3(0.1 + 3.0 * x(1, i), -2.0 * x(0, i), 1.5 * x(1, i));
        x.col(i) += Vector3(0.05 * x(1, i), 0.8 * x(0, i) * x(0, i), -0.6 * x(0, i) * x(2, i));
    }
    simulation->set_state(x, v);
    const auto before = momenta();
    simulation->step(0.1, 1000);
    const auto after = momenta();
    EXPECT_LT((after.col(0) - before.col(0)).norm(), 1e-10 * before.col(0).norm());
    EXPECT_LT((after.col(1) - before.col(1)).norm(), 1e-2 * before.col(1).norm()); // with the square of the step
    EXPECT_GT((simulation->positions() - x).norm(), 0.1);
}

TEST_P(ScaledExplicitMethod, ComesToTheEquilibriumOfItsEnergy) {
    const auto simulation = prepare(method, lumpy_bar(hardness, true, 10.0)); // about critical
    simulation->set_external_forces(Vector3(0.0, 0.0, -1e-3).replicate(1, simulation->scene().body->mesh.num_nodes()));
    const auto expected = tests::equilibrium(*simulation);
    ASSERT_TRUE(expected.converged);
    const double longest = 0.8 * models::critical_time_step(*simulation, models::scale_masses(*simulation));
    const double tenth = 0.1; // [s]
    for (int i = 0; i < 20; ++i)
        simulation->step(tenth, static_cast<int>(std::ceil(tenth / longest)));
    const double size = (expected.positions - interactive::rest_positions(simulation->scene())).norm();
    EXPECT_LT((simulation->positions() - expected.positions).norm(), 1e-3 * size);
}

TEST_P(ScaledExplicitMethod, MovesInSinglePrecisionAsInDouble) {
    interactive::Field ends[2], unscaled;
    for (const auto *moved_by : {&method, &slow}) {
        const auto scene = lumpy_bar(hardness, true, 5.0);
        const auto simulation = prepare(*moved_by, scene), plain = moved_by->prepare(scene);
        const double h = 0.5 * plain->critical_time_step();
        const auto pull = [&](interactive::Simulation &of) {
            of.set_external_forces(Vector3(1e-3, 0.0, -4e-3).replicate(1, scene.body->mesh.num_nodes()));
            of.set_targets(of.targets().colwise() + Vector3(2e-3, 4e-3, -5e-3));
            of.step(400.0 * h, 400);
        };
        pull(*simulation);
        ends[moved_by == &slow] = simulation->positions();
        pull(*plain);
        unscaled = plain->positions();
    }
    const double motion = (ends[1] - method.prepare(lumpy_bar(1.0, true))->positions()).norm();
    EXPECT_LT((ends[0] - ends[1]).norm(), 1e-4 * motion);
    EXPECT_LT((unscaled - ends[1]).norm(), 0.05 * motion); // the lump hardly deforms
    EXPECT_GT((unscaled - ends[1]).norm(), 1e-4 * motion);
}

TEST_P(ScaledExplicitMethod, LeavesABodyOfOneMaterialAsItIs) {
    const auto simulation = method.prepare(lumpy_bar(1.0, true));
    EXPECT_EQ(models::correction_of(models::scale_masses(*simulation)), nullptr);
}

INSTANTIATE_TEST_SUITE_P(All, ScaledExplicitMethod, testing::Values("tled", "tled_nodal_pressure", "tled_quadratic"));

TEST(ScaledMasses, AreNothingForMethodsThatTakeOtherSteps) {
    const auto scene = lumpy_bar(hardness, true);
    for (const auto &method : interactive::all_methods()) {
        const auto simulation = method.prepare(scene);
        EXPECT_EQ(simulation->correct_steps(nullptr), method.is_explicit) << method.name;
        EXPECT_EQ(std::isfinite(simulation->critical_time_step()), method.is_explicit) << method.name;
    }
}

} // namespace
} // namespace livermark
