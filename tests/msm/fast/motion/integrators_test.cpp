#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/integrator.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"
#include "tests/not_a_number.hpp"
#include "tests/samples/moving_samples.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;
using tests::nan;

/// u'' + 2 zeta omega u' + omega^2 u = 0 of one unknown.
struct Oscillator {
    double omega = 2.0;
    double zeta = 0.1;

    msm::EquationOfMotion equation() const {
        msm::EquationOfMotion equation;
        equation.mass = Eigen::VectorXd::Constant(1, 3.0);
        equation.acceleration = [*this](const Eigen::VectorXd &u, const Eigen::VectorXd &v, Eigen::VectorXd &a) {
            a = -omega * omega * u - 2.0 * zeta * omega * v;
        };
        equation.effective_mass = [*this](const Eigen::VectorXd &, double d, double k) {
            Eigen::SparseMatrix<double> matrix(1, 1);
            matrix.insert(0, 0) = 3.0 * (1.0 + d * 2.0 * zeta * omega + k * omega * omega);
            return matrix;
        };
        return equation;
    }

    /// From u = 1, v = 0.
    Eigen::Vector2d exact(double t) const {
        const double damped = omega * std::sqrt(1.0 - zeta * zeta);
        const double decay = std::exp(-zeta * omega * t);
        return {decay * (std::cos(damped * t) + zeta * omega / damped * std::sin(damped * t)),
                -decay * omega * omega / damped * std::sin(damped * t)};
    }
};

/// A lump of springs, its nodes moved and pushed at random.
struct Lump {
    core::Body body;
    core::SpringNetwork springs;
    msm::NodalConditions conditions;
    msm::State start;

    Lump() : body(*tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2}), {1060.0, 5000.0, 0.25})) {
        springs = msm::spring_network(body, msm::all_spring_laws().front());
        const auto size = body.mesh.points.size();
        conditions = tests::free_conditions(size);
        std::mt19937 generator(7);
        std::uniform_real_distribution<double> part(-1.0, 1.0);
        start.displacement.resize(static_cast<Eigen::Index>(3 * size));
        start.velocity.resize(start.displacement.size());
        for (Eigen::Index i = 0; i < start.displacement.size(); ++i) {
            start.displacement[i] = 0.004 * part(generator);
            start.velocity[i] = 0.1 * part(generator);
        }
    }

    double energy(const msm::EquationOfMotion &equation, const msm::State &state) const {
        const auto moved = msm::moved(body.mesh.points, msm::to_field(state.displacement));
        return msm::elastic_energy(springs, moved) + msm::kinetic_energy(equation, state);
    }

    Vector3 momentum(const msm::State &state) const {
        Vector3 sum = Vector3::Zero();
        for (std::size_t i = 0; i < springs.node_mass.size(); ++i)
            sum += springs.node_mass[i] * state.velocity.segment<3>(static_cast<Eigen::Index>(3 * i));
        return sum;
    }

    Vector3 angular_momentum(const msm::State &state) const {
        Vector3 sum = Vector3::Zero();
        for (std::size_t i = 0; i < springs.node_mass.size(); ++i) {
            const auto at = static_cast<Eigen::Index>(3 * i);
            const Vector3 place = body.mesh.points[i] + state.displacement.segment<3>(at);
            sum += springs.node_mass[i] * place.cross(Vector3(state.velocity.segment<3>(at)));
        }
        return sum;
    }
};

class Integrators : public testing::TestWithParam<msm::Integrator> {};

} // namespace

TEST_P(Integrators, HaveTheirOrderOnADampedOscillation) {
    const Oscillator oscillator;
    const auto equation = oscillator.equation();
    const auto error = [&](int num_steps) {
        constexpr double end = 3.0;
        const auto step = GetParam().prepare(equation, end / num_steps);
        msm::State state{Eigen::VectorXd::Ones(1), Eigen::VectorXd::Zero(1)};
        for (int n = 0; n < num_steps; ++n)
            step(state);
        return (Eigen::Vector2d(state.displacement[0], state.velocity[0]) - oscillator.exact(end)).norm();
    };
    EXPECT_NEAR(std::log2(error(400) / error(800)), GetParam().order, 0.06);
}

/// Springs and axial dashpots only act between two nodes.
TEST_P(Integrators, ConserveMomentumOfFreeSprings) {
    const Lump lump;
    const auto equation = msm::elastic_motion(lump.springs, lump.body.mesh.points, lump.conditions, {0.0, 1e-3});
    auto state = lump.start;
    const Vector3 before = lump.momentum(state);
    const auto step = GetParam().prepare(equation, 1e-3);
    for (int n = 0; n < 200; ++n)
        step(state);
    EXPECT_LT((lump.momentum(state) - before).norm(), 1e-8 * before.norm());
    EXPECT_GT((state.velocity - lump.start.velocity).norm(), 0.1 * lump.start.velocity.norm());
}

/// Integrators that keep a symplectic form keep the energy within bounds, and the angular momentum exactly; the others
/// do not even over a thousandth of the time, unless the step is small.
TEST_P(Integrators, KeepEnergyWithinBoundsIfSymplectic) {
    const Lump lump;
    const auto equation = msm::elastic_motion(lump.springs, lump.body.mesh.points, lump.conditions, {});
    auto state = lump.start;
    const auto step = GetParam().prepare(equation, 4e-3);
    const double before = lump.energy(equation, state);
    const Vector3 spin = lump.angular_momentum(state);
    double largest = 0.0, smallest = std::numeric_limits<double>::infinity();
    const int num_steps = GetParam().is_symplectic ? 100000 : 1000;
    for (int n = 0; n < num_steps; ++n) {
        step(state);
        if (n % 10 == 0) {
            const double energy = lump.energy(equation, state);
            largest = std::max(largest, energy);
            smallest = std::min(smallest, energy);
        }
    }
    if (GetParam().is_symplectic) {
        EXPECT_LT(largest, 1.35 * before);
        EXPECT_GT(smallest, 0.65 * before);
        EXPECT_LT((lump.angular_momentum(state) - spin).norm(), 1e-9 * spin.norm());
    } else {
        EXPECT_TRUE(!(largest < 1.0001 * before) || smallest < 0.9999 * before);
    }
}

TEST_P(Integrators, FollowTheNonlinearSprings) {
    const Lump lump;
    const auto equation = msm::elastic_motion(lump.springs, lump.body.mesh.points, lump.conditions, {1.0, 1e-3});
    const auto run = [&](const msm::Integrator &integrator, int num_steps) {
        auto state = lump.start;
        const auto step = integrator.prepare(equation, 0.05 / num_steps);
        for (int n = 0; n < num_steps; ++n)
            step(state);
        return state;
    };
    const auto &integrators = msm::known_integrators();
    const auto exact = run(*std::ranges::find(integrators, "runge_kutta_4", &msm::Integrator::name), 1000);
    const auto error = [&](int num_steps) {
        return (run(GetParam(), num_steps).displacement - exact.displacement).norm() / exact.displacement.norm();
    };
    const double coarse = error(100), fine = error(200);
    EXPECT_LT(fine, 0.05);
    EXPECT_NEAR(std::log2(coarse / fine), GetParam().order, 0.3);
}

TEST_P(Integrators, EvaluateTheForcesAsOftenAsTheySay) {
    auto equation = Oscillator().equation();
    int num_forces = 0;
    equation.acceleration = [&num_forces, acceleration = equation.acceleration](
                                const Eigen::VectorXd &u, const Eigen::VectorXd &v, Eigen::VectorXd &a) {
        ++num_forces;
        acceleration(u, v, a);
    };
    const auto step = GetParam().prepare(equation, 0.1);
    msm::State state{Eigen::VectorXd::Ones(1), Eigen::VectorXd::Zero(1)};
    for (int n = 0; n < 3; ++n)
        step(state);
    if (GetParam().is_explicit) {
        EXPECT_EQ(num_forces, 3 * GetParam().forces_per_step);
    } else {
        EXPECT_EQ(GetParam().forces_per_step, 0);
    }
}

TEST_P(Integrators, LeaveConstrainedUnknownsAlone) {
    Lump lump;
    lump.conditions.displacement[3] = {0.0, nan, nan};
    lump.conditions.displacement[8] = Vector3::Zero();
    lump.conditions.force[5] = {0.0, 0.0, 0.1};
    const auto equation = msm::elastic_motion(lump.springs, lump.body.mesh.points, lump.conditions, {0.5, 1e-3});
    auto state = lump.start;
    for (const Eigen::Index constrained : {9, 24, 25, 26})
        state.velocity[constrained] = 0.0;
    const auto step = GetParam().prepare(equation, 1e-3);
    for (int n = 0; n < 10; ++n)
        step(state);
    for (const Eigen::Index constrained : {9, 24, 25, 26}) {
        EXPECT_EQ(state.velocity[constrained], 0.0);
        EXPECT_EQ(state.displacement[constrained], lump.start.displacement[constrained]);
    }
    EXPECT_NE(state.displacement[10], lump.start.displacement[10]);
}

INSTANTIATE_TEST_SUITE_P(All, Integrators,
                         testing::ValuesIn(msm::known_integrators().begin(), msm::known_integrators().end()),
                         [](const auto &info) { return info.param.name; });

TEST(ElasticMotion, IsTheGradientOfTheEnergyPerMass) {
    Lump lump;
    lump.conditions.force[2] = {0.1, -0.2, 0.3};
    const auto equation = msm::elastic_motion(lump.springs, lump.body.mesh.points, lump.conditions, {0.7, 0.0});
    Eigen::VectorXd a(lump.start.displacement.size());
    equation.acceleration(lump.start.displacement, lump.start.velocity, a);
    const auto moved = msm::moved(lump.body.mesh.points, msm::to_field(lump.start.displacement));
    const auto gradient = msm::elastic_gradient(lump.springs, moved);
    const Eigen::VectorXd expected =
        (msm::to_unknowns(lump.conditions.force) - msm::to_unknowns(gradient)).cwiseQuotient(equation.mass) -
        0.7 * lump.start.velocity;
    EXPECT_LT((a - expected).norm(), 1e-13 * expected.norm());
}

/// At rest the dashpots are beta K, and a rigid rotation does not feel them.
TEST(ElasticMotion, DampsAlongTheSpringsOnly) {
    const Lump lump;
    constexpr double beta = 2e-3;
    const auto equation = msm::elastic_motion(lump.springs, lump.body.mesh.points, lump.conditions, {0.0, beta});
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(lump.start.displacement.size());
    Eigen::VectorXd a(rest.size());
    equation.acceleration(rest, lump.start.velocity, a);
    const Eigen::VectorXd expected =
        -beta * (msm::elastic_hessian(lump.springs, lump.body.mesh.points, msm::Tangent::exact) * lump.start.velocity)
                    .cwiseQuotient(equation.mass);
    EXPECT_LT((a - expected).norm(), 1e-12 * expected.norm());

    std::vector<Vector3> rotation;
    for (const auto &point : lump.body.mesh.points)
        rotation.emplace_back(Vector3(1.0, 2.0, 3.0).cross(point));
    equation.acceleration(rest, msm::to_unknowns(rotation), a);
    EXPECT_LT(a.norm(), 1e-10 * expected.norm());
}

/// Closed forms of the linear oscillation.
TEST(CriticalTimeStep, IsTheKnownOneOfEachIntegrator) {
    const auto limit = [](std::string_view name, const core::RayleighDamping &damping) {
        const auto integrators = msm::known_integrators();
        return msm::critical_time_step(*std::ranges::find(integrators, name, &msm::Integrator::name), damping, 1.0,
                                       100.0) *
               100.0;
    };
    EXPECT_NEAR(limit("symplectic_euler", {}), 2.0, 1e-6);
    EXPECT_NEAR(limit("velocity_verlet", {}), 2.0, 1e-6);
    EXPECT_NEAR(limit("runge_kutta_4", {}), 2.0 * std::numbers::sqrt2, 1e-6);
    EXPECT_EQ(limit("explicit_euler", {}), 0.0);
    EXPECT_EQ(limit("heun", {}), 0.0);
    EXPECT_EQ(limit("runge_kutta_chebyshev", {}), 0.0);
    EXPECT_EQ(limit("implicit_euler", {}), std::numeric_limits<double>::infinity());
    // Explicit Euler bears h <= 2 zeta / omega = alpha / omega^2 + beta where zeta < 1.
    EXPECT_NEAR(limit("explicit_euler", {1.0, 0.0}), 1e-2, 1e-6);
    EXPECT_NEAR(limit("explicit_euler", {0.0, 0.005}), 0.5, 1e-6);
    // Both ends overdamped and critical damping in between: on the negative real axis the limit of Runge-Kutta
    // is 2.7853 over the faster rate, omega (zeta + sqrt(zeta^2 - 1)).
    const double zeta = 0.5 * (3.0 / 100.0 + 0.1 * 100.0);
    EXPECT_NEAR(limit("runge_kutta_4", {3.0, 0.1}), 2.785293563 / (zeta + std::sqrt(zeta * zeta - 1.0)), 1e-6);
    // And 2 w_0 / w_1 with the polynomial of 8 stages and epsilon = 2/13, which is even about its middle.
    EXPECT_NEAR(limit("runge_kutta_chebyshev", {3.0, 0.1}), 41.21611088 / (zeta + std::sqrt(zeta * zeta - 1.0)), 1e-6);
    // Symplectic Euler with (omega h)^2 + 4 zeta omega h = 4.
    EXPECT_NEAR(limit("symplectic_euler", {0.0, 0.01}), std::sqrt(1.0 + 4.0) - 1.0, 1e-6);
}

namespace {

/// The value after a step from y = 1 where y' = z y.
double amplification(const std::vector<msm::ChebyshevStage> &stages, double z) {
    double before = 0.0, last = 0.0;
    for (const auto &stage : stages) {
        const double next =
            stage.mu * last + stage.nu * before + stage.mu_tilde * z * (1.0 + last) + stage.gamma_tilde * z;
        before = last;
        last = next;
    }
    return 1.0 + last;
}

/// T_s and its derivatives where x = cosh(t) > 1.
struct Chebyshev {
    double value, slope, curvature;

    Chebyshev(int s, double x) {
        const double t = std::acosh(x), root = std::sqrt(x * x - 1.0);
        value = std::cosh(s * t);
        slope = s * std::sinh(s * t) / root;
        curvature = (s * s * value - x * slope) / (x * x - 1.0);
    }
};

class ChebyshevStages : public testing::TestWithParam<std::tuple<int, double>> {
  protected:
    const int s = std::get<0>(GetParam());
    const double epsilon = std::get<1>(GetParam());
    const std::vector<msm::ChebyshevStage> stages = msm::chebyshev_stages(s, epsilon);
    const double w0 = 1.0 + epsilon / (s * s);
    const Chebyshev at_w0{s, w0};
    const double w1 = at_w0.slope / at_w0.curvature;
};

} // namespace

/// In closed form on the negative real axis, where w_0 + w_1 z lies between -1 and 1.
TEST_P(ChebyshevStages, HaveTheStabilityPolynomialOfTheMethod) {
    const double b = at_w0.curvature / (at_w0.slope * at_w0.slope);
    for (int i = 0; i <= 100; ++i) {
        const double angle = std::acos(-1.0) * i / 100.0;
        const double z = (std::cos(angle) - w0) / w1;
        EXPECT_NEAR(amplification(stages, z), 1.0 - b * at_w0.value + b * std::cos(s * angle), 1e-9) << z;
    }
}

TEST_P(ChebyshevStages, AreStableAsFarAsTheySay) {
    const double end = -(w0 + 1.0) / w1;
    for (int i = 1; i < 1000; ++i)
        EXPECT_LT(std::abs(amplification(stages, end * i / 1000.0)), 1.0) << i;
    EXPECT_GT(std::abs(amplification(stages, 1.5 * end)), 1.0);
    // The paper's estimate of how far that is.
    EXPECT_NEAR(-end, 2.0 / 3.0 * (s * s - 1) * (1.0 - 2.0 / 15.0 * epsilon), 0.02 * -end);
}

/// R(z) = exp(z) + O(z^3).
TEST_P(ChebyshevStages, AreOfSecondOrder) {
    const auto error = [&](double z) { return std::abs(amplification(stages, z) - std::exp(z)); };
    EXPECT_NEAR(std::log2(error(-0.02) / error(-0.01)), 3.0, 0.05);
    EXPECT_NEAR(stages.back().time, 1.0, 1e-13);
}

/// y' = t tells where in time the stages stand, and a method of second order is exact for it.
TEST_P(ChebyshevStages, StandWhereTheirTimesSay) {
    double before = 0.0, last = 0.0, time = 0.0;
    for (const auto &stage : stages) {
        EXPECT_GT(stage.time, time);
        const double next = stage.mu * last + stage.nu * before + stage.mu_tilde * time;
        before = last;
        last = next;
        time = stage.time;
    }
    EXPECT_NEAR(last, 0.5, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(All, ChebyshevStages,
                         testing::Combine(testing::Values(2, 3, 5, 8, 20), testing::Values(2.0 / 13.0, 0.5)));

} // namespace livermark
