#include <gtest/gtest.h>
#include <vector>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/support/input_error.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/spring_energy.hpp"
#include "msm/springs/springs.hpp"
#include "msm/statics/rest_stiffness.hpp"
#include "tests/samples/moving_samples.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

/// A soft bar with a hard lump in its middle, of neo-Hookean springs around nodes.
struct Bar {
    core::Body body = tests::lumpy_bar({6, 3, 3}, 30.0);
    msm::ElasticBody springs{{}, {}};
    msm::NodalConditions conditions = tests::free_conditions(body.mesh.points.size());

    /// @param averages_volumes  see msm::CoupledSprings
    explicit Bar(bool is_held = false, bool averages_volumes = false) {
        auto chosen = msm::find_coupled_springs("nodal_neo_hookean");
        chosen.averages_volumes = averages_volumes;
        springs = msm::coupled_springs_with_volume(body, chosen);
        if (is_held)
            for (std::size_t i = 0; i < body.mesh.points.size(); ++i)
                if (body.mesh.points[i].x() == 0.0)
                    conditions.displacement[i].setZero();
    }

    msm::MassScaling scaling() const { return msm::scale_masses(body, springs, conditions); }
    double highest(const msm::MassScaling &scaling) const {
        return msm::largest_angular_frequency(springs, body.mesh.points, conditions, scaling);
    }
    /// Bent, twisted and thrown.
    msm::State thrown() const {
        msm::State state;
        std::vector<Vector3> displacement, velocity;
        for (const auto &x : body.mesh.points) {
            displacement.emplace_back(0.05 * x.y(), 0.8 * x.x() * x.x(), -0.6 * x.x() * x.z());
            velocity.emplace_back(0.1 + 3.0 * x.y(), -2.0 * x.x(), 1.5 * x.y());
        }
        return {msm::to_unknowns(displacement), msm::to_unknowns(velocity)};
    }
    void stop_what_is_held(msm::State &state) const {
        for (std::size_t i = 0; i < body.mesh.points.size(); ++i)
            if (!std::isnan(conditions.displacement[i].x())) {
                msm::node_part(state.displacement, static_cast<int>(i)).setZero();
                msm::node_part(state.velocity, static_cast<int>(i)).setZero();
            }
    }
    msm::EquationOfMotion equation(const msm::MassScaling &scaling) const {
        return msm::elastic_motion(springs, body.mesh.points, conditions, {}, scaling);
    }
    double elastic_energy(const msm::State &state) const {
        return msm::elastic_energy(springs, msm::to_field(msm::to_unknowns(body.mesh.points) + state.displacement));
    }
};

struct Momenta {
    Vector3 linear = Vector3::Zero(), angular = Vector3::Zero();
};

Momenta momenta(const Bar &bar, const msm::State &state) {
    Momenta sum;
    const auto position = msm::to_field(msm::to_unknowns(bar.body.mesh.points) + state.displacement);
    const auto velocity = msm::to_field(state.velocity);
    for (std::size_t i = 0; i < position.size(); ++i) {
        sum.linear += bar.springs.node_mass[i] * velocity[i];
        sum.angular += bar.springs.node_mass[i] * position[i].cross(velocity[i]);
    }
    return sum;
}

msm::State after(const Bar &bar, const msm::MassScaling &scaling, double time_step, double duration) {
    const auto equation = bar.equation(scaling);
    const auto step = msm::find_integrator("symplectic_euler").prepare(equation, time_step);
    auto state = bar.thrown();
    for (int s = 0; s < std::lround(duration / time_step); ++s)
        step(state);
    return state;
}

TEST(MassScaling, FindsTheLumpAndLeavesAPlainBodyAlone) {
    Bar bar;
    const auto parts = msm::stiff_parts(bar.body);
    ASSERT_EQ(parts.size(), 1U);
    for (const int node : parts.front()) {
        EXPECT_GE(bar.body.mesh.points[node].x(), 0.04 - 1e-9);
        EXPECT_LE(bar.body.mesh.points[node].x(), 0.08 + 1e-9);
    }
    EXPECT_EQ(parts.front().size(), 48U);
    bar.body.materials[1] = bar.body.materials[0];
    EXPECT_TRUE(msm::stiff_parts(bar.body).empty());
    EXPECT_TRUE(bar.scaling().parts.empty());
}

TEST(MassScaling, MakesTheCriticalStepThatOfTheSoftTissue) {
    const Bar bar;
    const auto scaling = bar.scaling();
    ASSERT_EQ(scaling.parts.size(), 1U);
    EXPECT_GT(scaling.parts.front().factor, 10.0);
    auto soft_alone = bar.conditions;
    for (const int node : scaling.parts.front().nodes)
        soft_alone.displacement[node].setZero();
    const double rest_frequency = msm::largest_angular_frequency(bar.springs, bar.body.mesh.points, soft_alone);
    EXPECT_GT(bar.highest({}), 3.5 * rest_frequency);
    EXPECT_LT(bar.highest(scaling), 1.25 * rest_frequency);
    EXPECT_GE(bar.highest(scaling), (1.0 - 1e-9) * rest_frequency); // Cauchy's interlacing
}

TEST(MassScaling, IsStableUpToThePredictedStepAndNotBeyond) {
    const Bar bar(true);
    const auto scaling = bar.scaling();
    const double predicted = 2.0 / bar.highest(scaling);
    const double observed =
        msm::observed_time_step(msm::find_integrator("symplectic_euler"), bar.springs, bar.body.mesh.points,
                                bar.conditions, {}, predicted, {.num_accelerations = 3000, .scaling = scaling});
    EXPECT_NEAR(observed, predicted, 0.01 * predicted);
}

TEST(MassScaling, KeepsMomentumAndAngularMomentumOfABodyThatTumbles) {
    const Bar bar;
    const auto scaling = bar.scaling();
    const auto before = momenta(bar, bar.thrown());
    const auto later = momenta(bar, after(bar, scaling, 0.5 / bar.highest(scaling), 0.5));
    EXPECT_LT((later.linear - before.linear).norm(), 1e-11 * before.linear.norm());
    EXPECT_LT((later.angular - before.angular).norm(), 1e-10 * before.angular.norm());
}

TEST(MassScaling, HasTheEnergyOfItsOwnMassWithoutDriftWhileItTumbles) {
    const Bar bar(false, true); // the springs that the bounds were found with
    const auto scaling = bar.scaling();
    const auto equation = bar.equation(scaling);
    const double time_step = 0.2 / bar.highest(scaling);
    const auto step = msm::find_integrator("symplectic_euler").prepare(equation, time_step);
    auto state = bar.thrown();
    const auto energy = [&] {
        const Eigen::VectorXd x = msm::to_unknowns(bar.body.mesh.points) + state.displacement;
        Eigen::VectorXd heavy = state.velocity;
        msm::scale_deformation(scaling, 1.0, x, heavy);
        return 0.5 * state.velocity.dot(equation.mass.cwiseProduct(heavy)) + bar.elastic_energy(state);
    };
    const double start = energy();
    double lowest = start, highest = start;
    for (int s = 0; s < 20000; ++s) {
        step(state);
        if (s % 10 == 0) {
            lowest = std::min(lowest, energy());
            highest = std::max(highest, energy());
        }
    }
    EXPECT_GT(lowest, 0.97 * start);
    EXPECT_LT(highest, 1.03 * start);
}

TEST(MassScaling, LeavesEveryEquilibriumAndRigidMotionAlone) {
    const Bar bar;
    const auto scaling = bar.scaling();
    const auto x = msm::to_unknowns(bar.body.mesh.points);
    std::vector<Vector3> turning;
    for (const auto &p : bar.body.mesh.points)
        turning.push_back(Vector3(1.0, -2.0, 0.5).cross(p) + Vector3(0.3, 0.1, -0.2));
    auto field = msm::to_unknowns(turning);
    const auto rigid = field;
    msm::scale_deformation(scaling, -1.0, x, field);
    EXPECT_LT((field - rigid).lpNorm<Eigen::Infinity>(), 1e-12);
    Eigen::VectorXd none = Eigen::VectorXd::Zero(x.size());
    msm::scale_deformation(scaling, -1.0, x, none);
    EXPECT_EQ(none, Eigen::VectorXd::Zero(x.size()));
}

TEST(MassScaling, HasTheMassThatItsInverseIsOf) {
    const Bar bar;
    const auto scaling = bar.scaling();
    const auto x = msm::to_unknowns(bar.body.mesh.points);
    const Eigen::VectorXd start = bar.thrown().velocity;
    auto field = start;
    msm::scale_deformation(scaling, 1.0, x, field);
    EXPECT_GT((field - start).norm(), 0.1 * start.norm());
    msm::scale_deformation(scaling, -0.5, x, field);
    msm::scale_deformation(scaling, -0.5, x, field);
    EXPECT_LT((field - start).norm(), 1e-12 * start.norm());
}

TEST(MassScaling, LowersTheLowestFrequenciesByWhatTheLumpDeforms) {
    const Bar bar(true);
    const auto scaling = bar.scaling();
    const auto &points = bar.body.mesh.points;
    const auto plain = msm::lowest_modes(bar.springs, points, bar.conditions, 3);
    const auto scaled = msm::lowest_modes(bar.springs, points, bar.conditions, 3, scaling);
    for (int mode = 0; mode < 3; ++mode) {
        // Rayleigh's quotient of the plain mode with the scaled mass bounds the sum of the lowest from above; where
        // masses change little it is the frequency.
        auto shape = msm::to_unknowns({plain.shape_of(mode).begin(), plain.shape_of(mode).end()});
        auto heavy = shape;
        msm::scale_deformation(scaling, 1.0, msm::to_unknowns(points), heavy);
        double mass = 0.0;
        for (std::size_t i = 0; i < points.size(); ++i)
            mass += bar.springs.node_mass[i] *
                    msm::node_part(shape, static_cast<int>(i)).dot(msm::node_part(heavy, static_cast<int>(i)));
        const double first_order = plain.angular_frequency[mode] / std::sqrt(mass);
        EXPECT_LT(scaled.angular_frequency[mode], plain.angular_frequency[mode]);
        EXPECT_NEAR(scaled.angular_frequency[mode], first_order,
                    0.2 * (plain.angular_frequency[mode] - first_order) + 1e-6);
    }
}

TEST(MassScaling, ComesToTheMotionOfTheUnscaledBodyAsItsFactorsComeToOne) {
    const Bar bar;
    auto scaling = bar.scaling();
    const double time_step = 0.05 / bar.highest({});
    const auto exact = after(bar, {}, time_step, 0.01);
    std::vector<double> errors;
    for (const double factor : {1.04, 1.02, 1.01}) {
        scaling.parts.front().factor = factor;
        const auto found = after(bar, scaling, time_step, 0.01);
        errors.push_back((found.displacement - exact.displacement).norm() / exact.displacement.norm());
    }
    EXPECT_GT(errors[2], 0.0);
    EXPECT_NEAR(errors[0] / errors[1], 2.0, 0.3); // in proportion to the mass that was added
    EXPECT_NEAR(errors[1] / errors[2], 2.0, 0.3);
}

TEST(MassScaling, MovesOnVectorUnitsAsTheOracleDoes) {
    const Bar bar(true);
    const auto scaling = bar.scaling();
    const double time_step = 0.8 * 2.0 / bar.highest(scaling);
    for (const auto &damping : {core::RayleighDamping{0.0, 0.0}, core::RayleighDamping{3.0, 1e-4}}) {
        const auto equation = msm::elastic_motion(bar.springs, bar.body.mesh.points, bar.conditions, damping, scaling);
        const auto step = msm::find_integrator("symplectic_euler").prepare(equation, time_step);
        auto expected = bar.thrown();
        bar.stop_what_is_held(expected);
        const auto start = expected;
        for (int s = 0; s < 5; ++s)
            step(expected);
        for (const auto precision : tests::both_precisions)
            for (const int num_threads : {1, 2}) {
                auto steps = msm::FastSteps::prepare(
                    bar.springs, bar.body.mesh.points, bar.conditions, damping, "symplectic_euler", time_step,
                    {.precision = precision, .num_threads = num_threads, .scaling = scaling});
                ASSERT_TRUE(steps.has_value());
                steps->set_state(start);
                steps->take(2);
                steps->take(3);
                const auto found = steps->state();
                EXPECT_LT((found.velocity - expected.velocity).norm(),
                          tests::tolerance(precision) * (expected.velocity - start.velocity).norm());
                EXPECT_LT((found.displacement - expected.displacement).norm(),
                          tests::tolerance(precision) * (expected.displacement - start.displacement).norm());
            }
    }
    EXPECT_FALSE(msm::FastSteps::prepare(bar.springs, bar.body.mesh.points, bar.conditions, {}, "runge_kutta_4",
                                         time_step, {.scaling = scaling}));
}

/// The same where some nodes of the lump are heavier, say because a tool lies on them.
TEST(MassScaling, MovesHeavierNodesOnVectorUnitsAsTheOracleDoes) {
    const Bar bar(true);
    const auto scaling = bar.scaling();
    auto heavier = bar.springs;
    auto loaded = scaling;
    auto &part = loaded.parts.front();
    ASSERT_GT(part.slow.cols(), 0);
    const auto touched = {0, 3, 17};
    for (const int i : touched) {
        part.mass[i] *= 4.0;
        heavier.node_mass[part.nodes[i]] = part.mass[i];
    }
    part.rest.colwise() -= Eigen::Vector3d(part.rest * part.mass / part.mass.sum());
    const Eigen::VectorXd mass = part.mass.transpose().replicate(3, 1).reshaped();
    const Eigen::LLT<Eigen::MatrixXd> gram(part.slow.transpose() * mass.asDiagonal() * part.slow);
    part.slow = gram.matrixL().solve(part.slow.transpose()).transpose();

    const double time_step = 0.8 * 2.0 / bar.highest(scaling);
    const auto equation = msm::elastic_motion(heavier, bar.body.mesh.points, bar.conditions, {}, loaded);
    const auto step = msm::find_integrator("symplectic_euler").prepare(equation, time_step);
    auto start = bar.thrown();
    bar.stop_what_is_held(start);
    for (const auto precision : tests::both_precisions) {
        auto steps = msm::FastSteps::prepare(bar.springs, bar.body.mesh.points, bar.conditions, {}, "symplectic_euler",
                                             time_step, {.precision = precision, .scaling = scaling});
        ASSERT_TRUE(steps.has_value());
        for (const int i : touched)
            steps->set_mass(part.nodes[i], part.mass[i]);
        steps->set_state(start);
        auto expected = steps->state();
        const auto before = expected;
        steps->take(5);
        for (int s = 0; s < 5; ++s)
            step(expected);
        EXPECT_LT((steps->state().velocity - expected.velocity).norm(),
                  tests::tolerance(precision) * (expected.velocity - before.velocity).norm());
        for (const int i : touched)
            steps->set_mass(part.nodes[i], bar.springs.node_mass[part.nodes[i]]);
        steps->set_state(start);
        steps->take(5);
        EXPECT_GT((steps->state().velocity - expected.velocity).norm(),
                  1e-3 * (expected.velocity - before.velocity).norm())
            << "the masses matter";
    }
}

} // namespace
} // namespace livermark
