#include <Eigen/Eigenvalues>
#include <cmath>
#include <complex>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/relaxation.hpp"
#include "msm/springs/springs.hpp"
#include "tests/oracles/relaxing_steps.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;
using msm::State;

/// One mass on one spring along x.
struct OneMass {
    static constexpr double stiffness = 50.0, mass = 0.02, length = 0.1, start = 0.01;
    std::vector<Vector3> positions{Vector3::Zero(), Vector3(length, 0.0, 0.0)};
    core::SpringNetwork springs{
        .node_mass = {mass, mass}, .edges = {{0, 1}}, .stiffness = {stiffness}, .rest_length = {length}};
    msm::NodalConditions conditions{
        .displacement = {Vector3::Zero(), Vector3(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0)},
        .constraint = {},
        .force = {Vector3::Zero(), Vector3::Zero()}};

    /// Its place after it was pulled at once and let go.
    double moved(const core::PronySeries &series, double time, int num_steps) const {
        const double step = time / num_steps;
        State state{Eigen::VectorXd::Zero(6), Eigen::VectorXd::Zero(6)};
        state.displacement[3] = start;
        state.velocity[3] = 0.5 * step * stiffness / mass * start; // half a step before
        msm::RelaxingBody body(springs, series);
        body.go_on(msm::to_unknowns(positions) + state.displacement, 0.0);
        tests::RelaxingSteps steps(std::move(body), positions, conditions, {}, step);
        steps.take(state, num_steps);
        return state.displacement[3];
    }

    /// The same in steps of an integrator that hold branches in between.
    double moved_with(const char *integrator, const core::PronySeries &series, double time, int num_steps,
                      int num_held) const {
        State state{Eigen::VectorXd::Zero(6), Eigen::VectorXd::Zero(6)};
        state.displacement[3] = start;
        msm::HeldSteps steps(springs, series, positions, conditions, {}, msm::find_integrator(integrator),
                             time / num_steps, num_held);
        steps.take(state, num_steps);
        return state.displacement[3];
    }

    /// The same of (x, v, h_1, ...)' = A (x, v, h_1, ...): with one branch an equation of third order in x.
    static double exact(const core::PronySeries &series, double time) {
        const auto size = static_cast<Eigen::Index>(2 + series.moduli.size());
        Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
        Eigen::VectorXd at(size);
        matrix(0, 1) = 1.0;
        matrix(1, 0) = -series.remaining() * stiffness / mass;
        at[0] = start, at[1] = 0.0;
        for (Eigen::Index b = 2; b < size; ++b) {
            const double modulus = series.moduli[static_cast<std::size_t>(b - 2)];
            matrix(1, b) = -1.0 / mass;
            matrix(b, 1) = modulus * stiffness;
            matrix(b, b) = -1.0 / series.times[static_cast<std::size_t>(b - 2)];
            at[b] = modulus * stiffness * start;
        }
        const Eigen::EigenSolver<Eigen::MatrixXd> eigen(matrix);
        const Eigen::VectorXcd parts = eigen.eigenvectors().partialPivLu().solve(at.cast<std::complex<double>>());
        const Eigen::VectorXcd grown = (eigen.eigenvalues() * time).array().exp() * parts.array();
        return (eigen.eigenvectors() * grown)[0].real();
    }
};

TEST(RelaxingSteps, MoveAMassAsItsEquationOfThirdOrderSaysAndOfSecondOrderInTheStep) {
    const OneMass one; // 0.126 s is a period
    for (const auto &series :
         {core::PronySeries{"fast", {0.5}, {0.004}}, core::PronySeries{"like", {0.5}, {0.05}},
          core::PronySeries{"slow", {0.5}, {3.0}}, core::PronySeries{"two", {0.3, 0.4}, {0.02, 0.3}}}) {
        const double time = 0.21, expected = OneMass::exact(series, time);
        const double coarse = one.moved(series, time, 200) - expected, fine = one.moved(series, time, 400) - expected;
        EXPECT_LT(std::abs(fine), 2e-3 * OneMass::start) << series.name;
        EXPECT_NEAR(coarse / fine, 4.0, 0.1) << series.name;
    }
}

TEST(HeldSteps, MoveAMassAsItsEquationSaysAndOfSecondOrderInTheTimeThatBranchesAreHeld) {
    const OneMass one;
    const double time = 0.21;
    for (const auto &series :
         {core::PronySeries{"like", {0.5}, {0.05}}, core::PronySeries{"two", {0.3, 0.4}, {0.02, 0.3}}})
        for (const auto *integrator : {"runge_kutta_4", "velocity_verlet"})
            for (const int num_held : {1, 4}) {
                // The last steps end in the middle of what they hold branches for.
                const int steps = 400 + num_held / 2, twice = 2 * steps;
                const double expected = OneMass::exact(series, time);
                const double coarse = one.moved_with(integrator, series, time, steps, num_held) - expected;
                const double fine = one.moved_with(integrator, series, time, twice, num_held) - expected;
                EXPECT_LT(std::abs(fine), 2e-3 * OneMass::start) << integrator << " " << num_held << series.name;
                EXPECT_NEAR(coarse / fine, 4.0, num_held == 1 ? 0.2 : 1.0) << integrator << " " << num_held;
            }
}

/// A block that is held on one side, pushed at random.
struct PushedBlock {
    PushedBlock() {
        auto load_case = tests::empty_load_case(body->mesh);
        tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
        conditions = msm::nodal_conditions({body, load_case}, elastic.node_mass);
        critical = 2.0 / msm::largest_angular_frequency(elastic, points(), conditions);
        std::mt19937 random(5);
        state = {Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(points().size())), {}};
        for (std::size_t i = 0; i < points().size(); ++i)
            for (int c = 0; c < 3; ++c)
                if (std::isnan(conditions.displacement[i][c]))
                    state.displacement[3 * static_cast<Eigen::Index>(i) + c] = 1e-7 * (random() / 2147483648.0 - 1.0);
        state.velocity = Eigen::VectorXd::Zero(state.displacement.size());
    }
    const std::vector<Vector3> &points() const { return body->mesh.points; }
    tests::RelaxingSteps steps(const core::PronySeries &series, double step) const {
        msm::RelaxingBody relaxing(elastic, series);
        relaxing.go_on(msm::to_unknowns(points()) + state.displacement, 0.0);
        return {std::move(relaxing), points(), conditions, {}, step};
    }

    std::shared_ptr<const core::Body> body =
        tests::make_body(tests::box_mesh({0.06, 0.03, 0.03}, {2, 1, 1}), {1060.0, 5e3, 0.4});
    msm::ElasticBody elastic = msm::coupled_springs_with_volume(*body, msm::find_coupled_springs("nodal_neo_hookean"));
    msm::NodalConditions conditions;
    double critical = 0.0; ///< step without branches [s]
    State state;
};

TEST(RelaxingSteps, AreStableWhereElasticOnesAreHoweverShortTheTimes) {
    const PushedBlock block;
    const auto grown = [&](double time_constant, double step, int num_steps) {
        auto steps = block.steps({"one", {0.7}, {time_constant}}, step);
        auto state = block.state;
        steps.take(state, num_steps);
        return state.displacement.norm() / block.state.displacement.norm();
    };
    EXPECT_GT(grown(1e12, 1.03 * block.critical, 20), 50.0); // nothing relaxes in time
    for (const double ratio : {1e-9, 0.1, 1.0, 10.0, 1e6})
        EXPECT_LT(grown(ratio * block.critical, 0.995 * block.critical, 400), 20.0) << ratio;
}

TEST(RelaxingSteps, LoseExactlyWhatBecomesHeat) {
    const PushedBlock block;
    const double step = 0.05 * block.critical;
    auto steps = block.steps({"two", {0.3, 0.3}, {3.0 * block.critical, 40.0 * block.critical}}, step);
    const auto equation = msm::elastic_motion(block.elastic, block.points(), block.conditions, {});
    const auto rest = msm::to_unknowns(block.points());
    auto state = block.state;
    const double start = steps.body().stored_energy(rest + state.displacement);
    double heat = 0.0;
    for (int s = 0; s < 400; ++s) {
        // Velocities stand half a step before positions: those of both neighbours make the one there.
        auto next = state;
        steps.take(next, 1);
        EXPECT_GE(steps.body().dissipated_energy(), heat);
        heat = steps.body().dissipated_energy();
        auto after = next;
        tests::RelaxingSteps copy = steps;
        copy.take(after, 1);
        const State middle{next.displacement, 0.5 * (next.velocity + after.velocity)};
        EXPECT_NEAR(msm::kinetic_energy(equation, middle) + steps.body().stored_energy(rest + next.displacement) + heat,
                    start, 0.01 * start);
        state = next;
    }
    EXPECT_GT(heat, 0.1 * start);
}

} // namespace
} // namespace livermark
