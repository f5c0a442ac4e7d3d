#include <cmath>
#include <gtest/gtest.h>
#include <limits>
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
    /// Part of a mode in a field, phi^T M u.
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

namespace {

using fem_reference::RitzSpace;

/// A body that is pulled, and let go from where that brings it. No copies: the matrices are referred to.
struct PulledBody {
    PulledBody(std::shared_ptr<const core::Body> of, int degree, const core::LoadCase &remaining_)
        : body(std::move(of)), remaining(remaining_), pulled(remaining_),
          system(fem_reference::assemble(*body, degree)), mass(fem_reference::consistent_mass(*body, system)),
          solver(compressed_rows(system.stiffness)) {
        tests::pull(pulled, body->mesh, "x_max", {0.3, 0.2, 0.1});
        const auto before = fem_reference::dof_conditions(pulled, system);
        conditions = fem_reference::dof_conditions(core::without_tractions(pulled), system);
        start = solver.solve(before.prescribed, before.load).displacement;
        rest = solver.solve(conditions.prescribed, conditions.load).displacement;
        pairs = fem_reference::lowest_eigenpairs(compressed_rows(system.stiffness), mass, conditions.prescribed, 3);
        let_go(300, 1.0 / 60.0, 0.05);
    }
    PulledBody(const PulledBody &) = delete;
    PulledBody &operator=(const PulledBody &) = delete;

    /// @param part   of the first period, that a step is long
    /// @param ratio  of damping, at the first frequency and at six times that
    void let_go(int num_steps, double part, double ratio) {
        const double first = pairs.angular_frequency[0];
        const std::vector<core::Probe> probes{{"middle", body->mesh.num_nodes() / 2},
                                              {"end", body->mesh.num_nodes() - 1}};
        pulled.release = core::Release{num_steps, part * 2.0 * std::numbers::pi / first,
                                       core::rayleigh_damping(ratio, first, 6.0 * first), probes};
    }

    RitzSpace space() {
        std::vector<double> force(start.size());
        system.stiffness.multiply(start, force);
        for (std::size_t i = 0; i < force.size(); ++i)
            force[i] = conditions.load[i] - force[i];
        return {system.stiffness, mass, solver, std::move(force)};
    }
    core::History fast() const {
        fem_reference::ConstrainedSolver solver(compressed_rows(system.stiffness));
        return fem_reference::release(*body, system, pulled, start, solver);
    }
    core::History slow() const { return fem_reference::release_step_by_step(*body, system, pulled, start); }

    std::shared_ptr<const core::Body> body;
    core::LoadCase remaining, pulled;
    fem_reference::ElasticSystem system;
    fem_reference::SymmetricMatrix mass;
    fem_reference::ConstrainedSolver solver;
    fem_reference::DofConditions conditions;
    std::vector<double> start, rest;
    fem_reference::EigenPairs pairs;
};

/// A beam that is neither slender nor symmetric.
std::shared_ptr<const core::Body> swinging_beam(const std::array<int, 3> &bricks = {10, 3, 2}) {
    return tests::make_body(tests::shaken_box_mesh({0.1, 0.03, 0.02}, bricks), {1060.0, 5000.0, 0.45});
}

core::LoadCase constrained(const core::Body &body, const Vector3 &where = Vector3::Zero()) {
    auto load_case = tests::empty_load_case(body.mesh);
    tests::prescribe(load_case, body.mesh, "x_min", where);
    return load_case;
}

/// Under gravity, what is constrained moved.
core::LoadCase constrained_elsewhere(const core::Body &body) {
    auto load_case = constrained(body, {0.0, 0.0, 0.001});
    load_case.acceleration = {0.0, 0.0, -0.05};
    return load_case;
}

void expect_same_motion(const core::History &fast, const core::History &slow, double tolerance) {
    EXPECT_EQ(fast.time, slow.time);
    EXPECT_EQ(fast.integrator, slow.integrator);
    EXPECT_EQ(fast.time_step, slow.time_step);
    EXPECT_LT(tests::relative_l2(fast.displacement, slow.displacement), tolerance);
    EXPECT_LT(tests::relative_l2(fast.frames, slow.frames), std::max(tolerance, 1e-7)); // of single precision
    EXPECT_LT(tests::relative_l2(fast.kinetic_energy, slow.kinetic_energy), tolerance);
    EXPECT_LT(tests::relative_l2(fast.strain_energy, slow.strain_energy), tolerance);
}

/// Parameter: degree of the elements.
class FemRitzMotion : public testing::TestWithParam<int> {};

} // namespace

/// The stiffness is there in its solutions only.
TEST_P(FemRitzMotion, IsTheSameBySolutionsAlone) {
    const auto body = swinging_beam();
    for (const auto &remaining : {constrained(*body), constrained_elsewhere(*body)}) {
        PulledBody pulled(body, GetParam(), remaining);
        auto at_zero = pulled.conditions.prescribed;
        for (double &value : at_zero)
            value = std::isnan(value) ? value : 0.0;
        std::vector<double> force(pulled.start.size());
        pulled.system.stiffness.multiply(pulled.start, force);
        const auto by_statics = fem_reference::release_by_statics(
            *body, pulled.system, pulled.pulled, pulled.start, force,
            [&](std::span<const double> f, std::span<double> x, std::span<double> k_x) {
                const auto found = pulled.solver.solve(at_zero, f);
                for (std::size_t i = 0; i < f.size(); ++i) {
                    x[i] = found.displacement[i];
                    k_x[i] = f[i] + found.residual[i];
                }
            });
        ASSERT_TRUE(by_statics);
        expect_same_motion(*by_statics, pulled.slow(), 1e-4);
    }
}

/// Beside steps of the whole body that are so short that they cost nothing.
TEST(FemRitzSteps, CostTheProbesWhatTheMotionSays) {
    const auto body = swinging_beam({5, 2, 2});
    PulledBody pulled(body, 1, constrained(*body));
    const auto history = pulled.fast();
    ASSERT_TRUE(history.observed_error);
    constexpr int finer = 16;
    pulled.let_go(300 * finer, 1.0 / 60.0 / finer, 0.05);
    const auto fine = pulled.slow();
    EXPECT_FALSE(fine.observed_error);
    const std::size_t num_probes = pulled.pulled.release->probes.size();
    std::vector<Vector3> expected;
    for (std::size_t record = 0; record < history.time.size(); ++record)
        for (std::size_t q = 0; q < num_probes; ++q)
            expected.push_back(fine.displacement[record * finer * num_probes + q]);
    const double error = tests::relative_l2(history.displacement, expected);
    EXPECT_GT(error, 1e-4);
    EXPECT_NEAR(history.observed_error->relative_l2, error, 0.05 * error);
    EXPECT_NEAR(history.observed_error->order, 2.0, 0.2);
    pulled.let_go(300, 1.0 / 60.0, 0.05);
    const auto in_longer_steps =
        fem_reference::error_of_longer_steps(pulled.pulled, pulled.slow(), [&](const core::LoadCase &longer) {
            return fem_reference::release_step_by_step(*body, pulled.system, longer, pulled.start);
        });
    ASSERT_TRUE(in_longer_steps);
    EXPECT_NEAR(in_longer_steps->relative_l2, error, 0.3 * error);
}

TEST(FemLongerSteps, SayNothingOfTooFewAndOfNoMotion) {
    const auto body = swinging_beam({2, 1, 1});
    PulledBody pulled(body, 1, constrained(*body));
    const auto observed = [&](int num_steps, bool moves) {
        pulled.let_go(num_steps, 1.0 / 60.0, 0.05);
        const auto start = moves ? pulled.start : std::vector<double>(pulled.start.size(), 0.0);
        const auto motion = [&](const core::LoadCase &load_case) {
            return fem_reference::release_step_by_step(*body, pulled.system, load_case, start);
        };
        return fem_reference::error_of_longer_steps(pulled.pulled, motion(pulled.pulled), motion).has_value();
    };
    EXPECT_TRUE(observed(4, true));
    EXPECT_TRUE(observed(7, true)); // the records that all have end after the fourth step
    EXPECT_FALSE(observed(3, true));
    EXPECT_FALSE(observed(8, false));
}

/// Mixed elements agree with displacements alone where nothing locks, and begin at their own static solution.
TEST(FemMixedMotion, IsThatOfDisplacementsAloneWhereNothingLocks) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.03, 0.02}, {10, 3, 2}), {1060.0, 5000.0, 0.35});
    auto load_case = constrained(*body);
    tests::pull(load_case, body->mesh, "x_max", {0.3, 0.2, 0.1});
    load_case.release =
        core::Release{300, 0.002, core::rayleigh_damping(0.05, 12.0, 70.0), {{"end", body->mesh.num_nodes() - 1}}};
    using fem_reference::Formulation;
    fem_reference::StaticSolver alone(body, 2),
        mixed(body, 2, fem_reference::SolverChoice::automatic, Formulation::mixed);
    const auto expected = alone.solve(load_case), found = mixed.solve_with_motion(load_case);
    EXPECT_FALSE(mixed.solve(load_case).history);
    ASSERT_TRUE(found.history);
    EXPECT_EQ(found.history->displacement[0], found.displacement.back());
    EXPECT_NEAR(found.history->strain_energy[0], found.strain_energy, 1e-6 * found.strain_energy);
    EXPECT_LT(tests::relative_l2(found.history->displacement, expected.history->displacement), 0.03);
    EXPECT_GT(tests::relative_l2(found.history->displacement, expected.history->displacement), 1e-6);
    double before = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < found.history->time.size(); ++k) {
        const double energy = found.history->kinetic_energy[k] + found.history->strain_energy[k];
        EXPECT_LT(energy, before * (1.0 + 1e-6));
        before = energy;
    }
}

TEST_P(FemRitzMotion, IsThatOfStepsOfTheWholeBody) {
    const auto body = swinging_beam();
    for (const auto &remaining : {constrained(*body), constrained_elsewhere(*body)}) {
        PulledBody pulled(body, GetParam(), remaining);
        auto space = pulled.space();
        ASSERT_TRUE(
            fem_reference::extend_until_converged(space, *pulled.pulled.release)); // and no steps of the whole body
        EXPECT_LT(space.size(), 100);
        expect_same_motion(pulled.fast(), pulled.slow(), 1e-4);
    }
}

TEST_P(FemRitzMotion, IsLeftToStepsOfTheWholeBodyWhereItTakesTooManyVectors) {
    const auto body = swinging_beam();
    PulledBody pulled(body, GetParam(), constrained_elsewhere(*body));
    const auto expect_steps = [&](Eigen::Index most_vectors) {
        auto space = pulled.space();
        EXPECT_FALSE(fem_reference::extend_until_converged(space, *pulled.pulled.release));
        EXPECT_LE(space.size(), most_vectors);
        const auto fast = pulled.fast(), slow = pulled.slow();
        EXPECT_EQ(fast.displacement, slow.displacement);
        EXPECT_EQ(fast.strain_energy, slow.strain_energy);
        EXPECT_GT(fast.observed_error.value().relative_l2, 0.0);
        EXPECT_FALSE(slow.observed_error);
    };
    pulled.let_go(300, 1.0 / 60.0, 0.0); // without damping, all the high modes that the release excites stay
    expect_steps(100);
    pulled.let_go(8, 1.0 / 60.0, 0.05); // so few steps are done before the space is found
    expect_steps(4);
}

TEST_P(FemRitzMotion, OfThreeModesIsExactInThreeVectors) {
    const auto body = swinging_beam();
    PulledBody pulled(body, GetParam(), constrained_elsewhere(*body));
    pulled.start = pulled.rest;
    for (int mode = 0; mode < 3; ++mode)
        for (std::size_t i = 0; i < pulled.start.size(); ++i)
            pulled.start[i] += 1e-4 * pulled.pairs.shape[mode][i];
    for (const double ratio : {0.0, 0.05, 2.0}) { // the last one overdamped
        pulled.let_go(300, 1.0 / 60.0, ratio);
        expect_same_motion(pulled.fast(), pulled.slow(), 1e-8);
    }
}

TEST_P(FemRitzMotion, HasNoMoreVectorsThanUnknownsAndIsExactWithThem) {
    const auto body = swinging_beam({2, 1, 1});
    PulledBody pulled(body, GetParam(), constrained_elsewhere(*body));
    pulled.let_go(1000, 1.0 / 60.0, 0.0);
    const auto num_free =
        std::ranges::count_if(pulled.conditions.prescribed, [](double value) { return std::isnan(value); });
    auto space = pulled.space();
    while (space.extend())
        ASSERT_LE(space.size(), num_free);
    EXPECT_FALSE(space.extend());
    expect_same_motion(pulled.fast(), pulled.slow(), 1e-4);
}

TEST_P(FemRitzMotion, IsNoneWhereNothingWasPulled) {
    const auto body = swinging_beam();
    PulledBody pulled(body, GetParam(), constrained(*body));
    pulled.start.assign(pulled.start.size(), 0.0);
    auto space = pulled.space();
    EXPECT_FALSE(space.extend());
    const auto history = pulled.fast();
    EXPECT_EQ(history.displacement, std::vector<Vector3>(2 * history.time.size(), Vector3::Zero()));
    EXPECT_EQ(history.frames.size(), 51 * body->mesh.points.size());
    EXPECT_EQ(history.kinetic_energy, std::vector<double>(history.time.size(), 0.0));
    EXPECT_EQ(history.strain_energy, history.kinetic_energy);
}

TEST_P(FemRitzMotion, IsTheSameEveryTime) {
    const auto body = swinging_beam();
    const PulledBody pulled(body, GetParam(), constrained_elsewhere(*body));
    const auto first = pulled.fast(), second = pulled.fast();
    EXPECT_EQ(first.displacement, second.displacement);
    EXPECT_EQ(first.frames, second.frames);
    EXPECT_EQ(first.kinetic_energy, second.kinetic_energy);
    EXPECT_EQ(first.strain_energy, second.strain_energy);
}

INSTANTIATE_TEST_SUITE_P(Degree, FemRitzMotion, testing::Values(1, 2));

} // namespace livermark
