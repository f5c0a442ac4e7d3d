#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/dynamics/release.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"

namespace livermark {

namespace {

using core::Vector3;
using fem_reference::Motion;

/// Parameter: degree of the elements.
class FemNewmark : public testing::TestWithParam<int> {
  protected:
    FemNewmark() {
        tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
        tests::pull(load_case, body->mesh, "x_max", {3.0, 1.0, 2.0});
        system = fem_reference::assemble(*body, GetParam());
        mass = fem_reference::consistent_mass(*body, system);
        conditions = fem_reference::dof_conditions(load_case, system);
        pairs = fem_reference::lowest_eigenpairs(compressed_rows(system.stiffness), mass, conditions.prescribed, 3);
        none.assign(conditions.load.size(), 0.0);
    }

    double period(int mode) const { return 2.0 * std::numbers::pi / pairs.angular_frequency[mode]; }
    fem_reference::Newmark newmark(double time_step, const core::RayleighDamping &damping = {}) const {
        return {system.stiffness, mass, damping, time_step, conditions.prescribed};
    }
    /// How much of a mode is in a field, phi^T M u.
    double amplitude(int mode, const std::vector<double> &field) const {
        std::vector<double> momentum(field.size());
        fem_reference::multiply_mass(mass, field, momentum);
        return fem_reference::dot(pairs.shape[mode], momentum);
    }
    /// A beam that is neither slender nor symmetric.
    std::shared_ptr<const core::Body> body =
        tests::make_body(tests::shaken_box_mesh({0.1, 0.03, 0.02}, {10, 3, 2}), {1060.0, 5000.0, 0.45});
    core::LoadCase load_case = tests::empty_load_case(body->mesh);
    fem_reference::ElasticSystem system;
    fem_reference::SymmetricMatrix mass;
    fem_reference::DofConditions conditions;
    fem_reference::EigenPairs pairs;
    std::vector<double> none; ///< no load, no velocity
};

/// Times at which a sampled oscillation passes through zero on its way down.
std::vector<double> falling_zeros(const std::vector<double> &samples, double time_step) {
    std::vector<double> zeros;
    for (std::size_t k = 1; k < samples.size(); ++k)
        if (samples[k - 1] > 0.0 && samples[k] <= 0.0)
            zeros.push_back(time_step * (static_cast<double>(k) - samples[k] / (samples[k] - samples[k - 1])));
    return zeros;
}

} // namespace

TEST_P(FemNewmark, PeriodOfAModeIsRightToAThousandth) {
    for (int mode = 0; mode < 3; ++mode) {
        const double time_step = period(mode) / 200.0;
        auto integrator = newmark(time_step);
        Motion motion{pairs.shape[mode], none};
        std::vector<double> samples{1.0};
        for (int step = 0; step < 200 * 11; ++step) {
            integrator.advance(motion, none);
            samples.push_back(amplitude(mode, motion.displacement));
        }
        const auto zeros = falling_zeros(samples, time_step);
        ASSERT_GE(zeros.size(), 11u);
        const double error = (zeros[10] - zeros[0]) / 10.0 / period(mode) - 1.0;
        EXPECT_LT(std::abs(error), 1e-3);
        // What theory gives the method: tan(omega' h / 2) = omega h / 2.
        const double half_angle = 0.5 * pairs.angular_frequency[mode] * time_step;
        EXPECT_NEAR(error, half_angle / std::atan(half_angle) - 1.0, 1e-7);
        // A mode stays what it is.
        for (int other = 0; other < 3; ++other)
            if (other != mode) {
                EXPECT_LT(std::abs(amplitude(other, motion.displacement)), 1e-7);
            }
        RecordProperty("period_error_" + std::to_string(mode), std::to_string(1e6 * error) + "e-6");
    }
}

TEST_P(FemNewmark, EnergyOfAnUndampedReleaseIsConserved) {
    fem_reference::ConstrainedSolver solver(compressed_rows(system.stiffness));
    Motion motion{solver.solve(conditions.prescribed, conditions.load).displacement, none};
    const int steps_per_period = 200, num_periods = 10;
    auto integrator = newmark(period(0) / steps_per_period);
    const auto total = [&] {
        const auto energy = integrator.energy(motion);
        return energy.kinetic + energy.strain;
    };
    const double start = total();
    double largest = 0.0;
    for (int step = 0; step < num_periods * steps_per_period; ++step) {
        integrator.advance(motion, none);
        if (step % 20 == 0)
            largest = std::max(largest, std::abs(total() / start - 1.0));
    }
    EXPECT_LT(largest / num_periods, 1e-10);
    EXPECT_GT(integrator.energy(motion).kinetic, 0.0);
    RecordProperty("energy_drift_per_period", std::to_string(1e15 * largest / num_periods) + "e-15");
}

TEST_P(FemNewmark, EnergyWithALoadThatStaysIsConserved) {
    auto integrator = newmark(period(0) / 50.0);
    Motion motion{none, none};
    double largest_work = 0.0, largest_error = 0.0;
    for (int step = 0; step < 100; ++step) {
        integrator.advance(motion, conditions.load);
        const double work = fem_reference::dot(conditions.load, motion.displacement);
        const auto energy = integrator.energy(motion);
        largest_work = std::max(largest_work, work);
        largest_error = std::max(largest_error, std::abs(energy.kinetic + energy.strain - work));
    }
    EXPECT_LT(largest_error, 1e-10 * largest_work);
}

TEST_P(FemNewmark, DampingRatioIsRecoveredToOnePercent) {
    // Five per cent in the first mode, half of it from each term, and what that makes of the others.
    const double first = pairs.angular_frequency[0];
    const core::RayleighDamping damping{0.05 * first, 0.05 / first};
    EXPECT_NEAR(damping.ratio(first), 0.05, 1e-15);
    for (int mode = 0; mode < 3; ++mode) {
        const double ratio = damping.ratio(pairs.angular_frequency[mode]);
        const double time_step = period(mode) / 200.0;
        auto integrator = newmark(time_step, damping);
        Motion motion{pairs.shape[mode], none};
        std::vector<double> samples, squares;
        const int num_steps = 200 * 5;
        for (int step = 0; step < num_steps; ++step) {
            integrator.advance(motion, none);
            samples.push_back(amplitude(mode, motion.displacement));
        }
        // Logarithmic decrement of the slopes at zeros that lie whole periods apart.
        const auto zeros = falling_zeros(samples, time_step);
        ASSERT_GE(zeros.size(), 4u);
        const auto slope = [&](double zero) {
            const auto k = static_cast<std::size_t>(zero / time_step);
            return samples[k] - samples[k + 1];
        };
        const double decrement = std::log(slope(zeros[0]) / slope(zeros[3])) / 3.0;
        const double found = decrement / std::hypot(2.0 * std::numbers::pi, decrement);
        EXPECT_NEAR(found, ratio, 0.01 * ratio) << "mode " << mode;
        RecordProperty("damping_error_" + std::to_string(mode), std::to_string(found / ratio - 1.0));
    }
}

TEST_P(FemNewmark, IsOfSecondOrderInTime) {
    const core::RayleighDamping damping{0.1 * pairs.angular_frequency[0], 0.02 / pairs.angular_frequency[0]};
    const double end = 1.3 * period(0);
    std::vector<double> errors;
    for (const int num_steps : {100, 200, 400}) {
        auto integrator = newmark(end / num_steps, damping);
        Motion motion{none, none};
        for (int mode = 0; mode < 2; ++mode)
            for (std::size_t i = 0; i < none.size(); ++i)
                motion.displacement[i] += pairs.shape[mode][i];
        for (int step = 0; step < num_steps; ++step)
            integrator.advance(motion, none);
        double error = 0.0;
        for (int mode = 0; mode < 2; ++mode) {
            const double omega = pairs.angular_frequency[mode], ratio = damping.ratio(omega);
            const double damped = omega * std::sqrt(1.0 - ratio * ratio);
            const double exact = std::exp(-ratio * omega * end) *
                                 (std::cos(damped * end) + ratio * omega / damped * std::sin(damped * end));
            error = std::hypot(error, amplitude(mode, motion.displacement) - exact);
        }
        errors.push_back(error);
    }
    EXPECT_NEAR(std::log2(errors[0] / errors[1]), 2.0, 0.1);
    EXPECT_NEAR(std::log2(errors[1] / errors[2]), 2.0, 0.05);
    RecordProperty("order", std::to_string(std::log2(errors[1] / errors[2])));
}

TEST_P(FemNewmark, ReleaseGoesFromTheStaticStartToRestUnderTheLoadsThatStay) {
    // What is constrained is moved as well and stays moved; gravity stays on. Damping by the stiffness, because this
    // method hardly damps the highest modes by the mass.
    core::LoadCase remaining = tests::empty_load_case(body->mesh);
    tests::prescribe(remaining, body->mesh, "x_min", {0.0, 0.0, 0.001});
    remaining.acceleration = {0.0, 0.0, -0.05};
    core::LoadCase pulled = remaining;
    tests::pull(pulled, body->mesh, "x_max", {0.0, 0.2, 0.1});
    const double first = pairs.angular_frequency[0];
    const std::vector<core::Probe> probes{{"corner", 10}, {"far", body->mesh.num_nodes() - 1}};
    pulled.release = core::Release{300, period(0) / 30.0, {0.5 * first, 0.5 / first}, probes};

    fem_reference::StaticSolver solver(body, GetParam());
    const auto solution = solver.solve(pulled);
    const auto rest = solver.solve(remaining);
    EXPECT_FALSE(rest.history);
    ASSERT_TRUE(solution.history);
    const auto &history = *solution.history;
    ASSERT_EQ(history.time.size(), 301u);
    ASSERT_EQ(history.displacement.size(), 602u);
    ASSERT_EQ(history.kinetic_energy.size(), 301u);
    ASSERT_EQ(history.strain_energy.size(), 301u);
    EXPECT_EQ(history.time[0], 0.0);
    EXPECT_NEAR(history.time[300], 10.0 * period(0), 1e-12);
    EXPECT_EQ(history.kinetic_energy[0], 0.0);
    EXPECT_NEAR(history.strain_energy[0], solution.strain_energy, 1e-12 * solution.strain_energy);
    EXPECT_NEAR(history.strain_energy[300], rest.strain_energy, 1e-6 * rest.strain_energy);
    for (std::size_t q = 0; q < probes.size(); ++q) {
        const auto &start = solution.displacement[probes[q].node], &end = rest.displacement[probes[q].node];
        EXPECT_EQ(history.displacement[q], start);
        EXPECT_GT((start - end).norm(), 1e-5);
        EXPECT_LT((history.displacement[600 + q] - end).norm(), 1e-6 * (start - end).norm());
    }
}

INSTANTIATE_TEST_SUITE_P(Degree, FemNewmark, testing::Values(1, 2));

} // namespace livermark
