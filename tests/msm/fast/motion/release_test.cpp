#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <set>
#include <vector>

#include "core/support/input_error.hpp"
#include "msm/dynamics/histories.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

constexpr double output_interval = 0.02; // [s]

/// A rod that is constrained at one end and damped, with a node of the other end as the probe.
struct Rod {
    core::Problem problem;
    core::SpringNetwork springs;
    msm::NodalConditions conditions;
    double highest;

    explicit Rod(const core::RayleighDamping &damping) {
        problem.body = tests::make_body(tests::box_mesh({0.2, 0.05, 0.05}, {8, 2, 2}), {1060.0, 5000.0, 0.25});
        const auto &mesh = problem.body->mesh;
        problem.load_case = tests::empty_load_case(mesh);
        problem.load_case.name = "rod";
        tests::prescribe(problem.load_case, mesh, "x_min", core::Vector3::Zero());
        core::Release release;
        release.damping = damping;
        release.output_interval = output_interval;
        release.num_steps = 25;
        release.probes = {{.name = "end", .node = static_cast<int>(mesh.points.size()) - 1}};
        problem.load_case.release = release;
        springs = msm::spring_network(*problem.body, msm::all_spring_laws().front());
        conditions = msm::nodal_conditions(problem, springs.node_mass);
        highest = msm::largest_angular_frequency(springs, mesh.points, conditions);
    }

    msm::StepPlan plan(const msm::TimeStepping &choice) const { return msm::plan_steps(problem, highest, choice); }

    /// Bent along its length and let go.
    core::History motion(const msm::TimeStepping &choice) const {
        const auto &points = problem.body->mesh.points;
        std::vector<core::Vector3> start;
        for (const auto &x : points)
            start.emplace_back(0.0, 0.0, 0.1 * x.x() * x.x());
        return msm::release(problem, springs, conditions, start, plan(choice));
    }
};

int forces(const msm::StepPlan &plan) {
    return plan.steps_per_record * plan.integrator.forces_per_step;
}

/// So much damping that the fastest oscillation is far beyond critical.
core::RayleighDamping strong_damping() {
    const double highest = Rod({}).highest;
    return {.alpha = 0.5, .beta = 30.0 / highest};
}

TEST(PlanOfSteps, TakesTheIntegratorThatNeedsFewerForces) {
    const double highest = Rod({}).highest;
    for (const double beta : {0.0, 0.1, 1.0, 3.0, 10.0, 100.0}) {
        const Rod rod({.alpha = 0.5, .beta = beta / highest});
        SCOPED_TRACE(beta);
        const auto chosen = rod.plan({});
        const auto accurate = rod.plan({.integrator = "runge_kutta_4"});
        if (beta == 0.0) {
            EXPECT_EQ(chosen.integrator.name, "runge_kutta_4");
            continue;
        }
        const auto stabilised = rod.plan({.integrator = "runge_kutta_chebyshev"});
        EXPECT_EQ(forces(chosen), std::min(forces(accurate), forces(stabilised)));
        EXPECT_EQ(chosen.integrator.name == "runge_kutta_4", forces(accurate) <= forces(stabilised));
    }
    EXPECT_EQ(Rod(strong_damping()).plan({}).integrator.name, "runge_kutta_chebyshev");
}

TEST(PlanOfSteps, TakesSafeStepsThatDivideTheInterval) {
    const Rod rod(strong_damping());
    for (const auto *integrator : {"runge_kutta_4", "runge_kutta_chebyshev", "symplectic_euler"}) {
        const auto plan = rod.plan({.integrator = integrator});
        EXPECT_EQ(plan.integrator.name, integrator);
        EXPECT_DOUBLE_EQ(plan.time_step * plan.steps_per_record, output_interval);
        EXPECT_LE(plan.time_step, msm::default_safety_factor * plan.critical_time_step * (1.0 + 1e-9));
    }
}

TEST(PlanOfSteps, LeavesNoFewerThanThreeToAStabilisedMethodUnlessAsked) {
    const double highest = Rod({}).highest;
    const Rod rod({.alpha = 0.0, .beta = 10.0 / highest});
    EXPECT_EQ(rod.plan({.integrator = "runge_kutta_chebyshev"}).steps_per_record, 3);
    const auto asked = rod.plan({.integrator = "runge_kutta_chebyshev", .time_step = 0.5 * output_interval});
    EXPECT_EQ(asked.steps_per_record, 2);
    EXPECT_GT(asked.critical_time_step, 0.5 * output_interval);
}

TEST(PlanOfSteps, TakesStepsOfAsManyForcesAsMakeTheFewestInAll) {
    const double highest = Rod({}).highest;
    const auto &usual = msm::find_integrator("runge_kutta_chebyshev");
    std::set<int> numbers;
    for (const double beta : {3.0, 10.0, 20.0, 30.0, 50.0, 100.0}) {
        SCOPED_TRACE(beta);
        const Rod rod({.alpha = 0.5, .beta = beta / highest});
        const auto chosen = rod.plan({.integrator = usual.name});
        numbers.insert(chosen.integrator.forces_per_step);
        EXPECT_DOUBLE_EQ(chosen.critical_time_step,
                         msm::critical_time_step(chosen.integrator, rod.problem.load_case.release->damping,
                                                 1e-3 * highest, highest));
        EXPECT_LE(chosen.time_step, msm::default_safety_factor * chosen.critical_time_step * (1.0 + 1e-9));
        int fewest = std::numeric_limits<int>::max();
        for (int number = 5; number <= 12; ++number) {
            const double longest =
                msm::default_safety_factor * msm::critical_time_step(usual.with_forces_per_step(number),
                                                                     rod.problem.load_case.release->damping,
                                                                     1e-3 * highest, highest);
            fewest = std::min(fewest, number * std::max(3, static_cast<int>(std::ceil(output_interval / longest))));
        }
        EXPECT_LE(forces(chosen), 1.1 * fewest); // how long steps of each number may be is estimated
    }
    EXPECT_GT(numbers.size(), 2);
}

TEST(PlanOfSteps, TakesTheStepAskedForWithWhatBearsIt) {
    const Rod rod(strong_damping());
    const double least = rod.plan({.integrator = "runge_kutta_4"}).critical_time_step;
    const double most = rod.plan({.integrator = "runge_kutta_chebyshev"}).critical_time_step;
    ASSERT_LT(2.0 * least, most);
    EXPECT_EQ(rod.plan({.time_step = 0.9 * least}).integrator.name, "runge_kutta_4");
    EXPECT_EQ(rod.plan({.time_step = 2.0 * least}).integrator.name, "runge_kutta_chebyshev");
    EXPECT_THROW(rod.plan({.integrator = "runge_kutta_4", .time_step = 2.0 * least}), support::InputError);
    EXPECT_THROW(rod.plan({.time_step = 1.1 * most}), support::InputError);
    EXPECT_NO_THROW(rod.plan({.time_step = 1.1 * most, .force = true}));
}

TEST(PlanOfSteps, RefusesWhatIsStableAtNoStep) {
    const Rod rod({});
    for (const auto *integrator : {"heun", "runge_kutta_chebyshev"}) {
        EXPECT_THROW(rod.plan({.integrator = integrator}), support::InputError);
        EXPECT_THROW(rod.plan({.integrator = integrator, .force = true}), support::InputError); // how long, then?
        EXPECT_NO_THROW(rod.plan({.integrator = integrator, .time_step = 1e-3, .force = true}));
    }
}

/// Over the root mean square of the expected motion.
double motion_error(const core::History &history, const std::vector<core::Vector3> &expected) {
    const auto motion = msm::to_unknowns(expected);
    return (msm::to_unknowns(history.displacement) - motion).norm() / motion.norm();
}

TEST(Release, MovesTheSameByAStabilisedMethodAsBySmallSteps) {
    const Rod rod(strong_damping());
    const auto found = rod.motion({});
    ASSERT_EQ(found.integrator, "runge_kutta_chebyshev");
    const auto expected = rod.motion(
        {.integrator = "runge_kutta_4", .time_step = 0.02 * found.time_step, .kernel = msm::StepKernel::scalar});
    ASSERT_EQ(found.displacement.size(), expected.displacement.size());
    double travelled = 0.0;
    for (const auto &u : expected.displacement)
        travelled = std::max(travelled, (u - expected.displacement[0]).norm());
    EXPECT_GT(travelled, 0.5 * expected.displacement[0].norm());
    EXPECT_LT(motion_error(found, expected.displacement), 1e-3);
}

using core::Vector3;

struct SwayingRod {
    core::Problem problem;
    core::SpringNetwork springs;
    msm::NodalConditions conditions;

    SwayingRod() {
        problem.body = tests::make_body(tests::shaken_box_mesh({0.2, 0.05, 0.05}, {8, 2, 2}), {1060.0, 5000.0, 0.25});
        problem.load_case = tests::empty_load_case(problem.body->mesh);
        tests::prescribe(problem.load_case, problem.body->mesh, "x_min", {0.001, 0.0, 0.0});
        tests::pull(problem.load_case, problem.body->mesh, "x_max", {0.0, 0.0, 2.0});
        problem.load_case.acceleration = {0.0, 0.0, -0.05};
        springs = msm::spring_network(*problem.body, msm::all_spring_laws().front());
        conditions = msm::nodal_conditions(problem, springs.node_mass);
    }
};

TEST(DynamicRelaxation, ComesToTheEquilibriumThatNewtonFinds) {
    const SwayingRod rod;
    const auto &points = rod.problem.body->mesh.points;
    const auto expected = msm::find_equilibrium(rod.springs, points, rod.conditions);
    ASSERT_EQ(expected.status, core::SolutionStatus::ok) << expected.message;
    for (const auto *const name : {"runge_kutta_4", "symplectic_euler", "velocity_verlet"}) {
        const auto found = msm::relax(msm::find_integrator(name), rod.springs, points, rod.conditions);
        ASSERT_EQ(found.equilibrium.status, core::SolutionStatus::ok) << name << ": " << found.equilibrium.message;
        EXPECT_LT(tests::relative_difference(found.equilibrium.displacement, expected.displacement), 1e-6) << name;
        EXPECT_LT(tests::relative_difference(found.equilibrium.constraint_force, expected.constraint_force), 1e-6)
            << name;
        EXPECT_GT(found.time_step, 0.0);
    }
}

TEST(DynamicRelaxation, SaysSoWhenItIsNotAtRest) {
    const SwayingRod rod;
    const auto found = msm::relax(msm::find_integrator("runge_kutta_4"), rod.springs, rod.problem.body->mesh.points,
                                  rod.conditions, 50);
    EXPECT_EQ(found.equilibrium.status, core::SolutionStatus::not_converged);
    EXPECT_NE(found.equilibrium.message.find("50 steps"), std::string::npos) << found.equilibrium.message;
}

constexpr double endless = 1e15; // [s]

/// A rod that is held at one end, pulled at the other, held until its stress has faded, and let go.
struct PulledRod {
    explicit PulledRod(const core::PronySeries &series, double hold = endless) {
        const auto body = tests::make_body(tests::box_mesh({0.06, 0.03, 0.03}, {2, 1, 1}), {1060.0, 5e3, 0.25});
        auto load_case = tests::empty_load_case(body->mesh);
        load_case.name = "rod";
        tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
        tests::pull(load_case, body->mesh, "x_max",
                    {0.5, 0.0, 0.25}); // it moves by less than a thousandth of its length
        std::vector<double> times{0.0, 1.0};
        for (double time = 2.0; time < std::min(1.0 + hold, 100.0); time *= 2.0)
            times.push_back(time);
        times.push_back(1.0 + hold);
        std::vector<double> factors(times.size(), 1.0);
        factors.front() = 0.0;
        load_case.slow_history = core::SlowHistory{.relaxation = series, .times = times, .factors = factors};
        const int last = static_cast<int>(body->mesh.points.size()) - 1;
        load_case.release = core::Release{
            .num_steps = 100, .output_interval = 0.004, .damping = {}, .probes = {{.name = "end", .node = last}}};
        problem = {body, load_case};
    }

    core::History motion(const msm::ElasticBody &elastic, const msm::TimeStepping &choice = {}) const {
        const auto &points = problem.body->mesh.points;
        const auto followed = msm::follow_history(elastic, problem, elastic.node_mass);
        const auto conditions = msm::nodal_conditions(problem, elastic.node_mass);
        const auto plan = msm::plan_steps(problem, msm::largest_angular_frequency(elastic, points, conditions), choice);
        const auto free =
            msm::nodal_conditions({problem.body, core::without_tractions(problem.load_case)}, elastic.node_mass);
        return msm::release(problem, elastic, free, followed.end.displacement, plan, followed.points);
    }
    msm::ElasticBody springs() const { return msm::spring_network(*problem.body, msm::all_spring_laws().front()); }

    core::Problem problem;
};

/// Displacement of a mode of that stiffness over its mass after it was let go from 1, of a body that relaxes as a whole
/// and has relaxed: (x, v, h)' = A (x, v, h), an equation of third order.
double standard_linear_solid(double square, double modulus, double tau, double time) {
    Eigen::Matrix3d matrix;
    matrix << 0.0, 1.0, 0.0, -(1.0 - modulus) * square, 0.0, -1.0, 0.0, modulus * square, -1.0 / tau;
    const Eigen::EigenSolver<Eigen::Matrix3d> eigen(matrix);
    const Eigen::Vector3cd parts =
        eigen.eigenvectors().partialPivLu().solve(Eigen::Vector3d(1.0, 0.0, 0.0).cast<std::complex<double>>());
    const Eigen::Vector3cd grown = (eigen.eigenvalues() * time).array().exp() * parts.array();
    return (eigen.eigenvectors() * grown)[0].real();
}

/// The motion of the probe, mode by mode.
std::vector<Vector3> exact_motion(const PulledRod &rod, const msm::ElasticBody &elastic, double modulus, double tau) {
    const auto &points = rod.problem.body->mesh.points;
    const auto conditions = msm::nodal_conditions(rod.problem, elastic.node_mass);
    const auto equation = msm::elastic_motion(elastic, points, conditions, {});
    const auto size = equation.mass.size();
    std::vector<Eigen::Index> free;
    for (Eigen::Index i = 0; i < size; ++i)
        if (std::isnan(conditions.displacement[static_cast<std::size_t>(i / 3)][i % 3]))
            free.push_back(i);
    Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(size, size);
    for (const auto &term : elastic.terms)
        stiffness += Eigen::MatrixXd(term->hessian(msm::to_unknowns(points), msm::Tangent::exact));
    const Eigen::MatrixXd k = stiffness(free, free);
    const Eigen::MatrixXd mass = equation.mass(free).asDiagonal();
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(k, mass);
    const Eigen::VectorXd load = msm::to_unknowns(conditions.force)(free);
    const Eigen::VectorXd start = k.ldlt().solve(load) / (1.0 - modulus);
    const Eigen::VectorXd amplitude = modes.eigenvectors().transpose() * mass * start;
    std::vector<Vector3> motion;
    const auto &release = *rod.problem.load_case.release;
    for (int record = 0; record <= release.num_steps; ++record) {
        Eigen::VectorXd now = amplitude;
        for (Eigen::Index m = 0; m < now.size(); ++m)
            now[m] *= standard_linear_solid(modes.eigenvalues()[m], modulus, tau, record * release.output_interval);
        Eigen::VectorXd all = Eigen::VectorXd::Zero(size);
        all(free) = modes.eigenvectors() * now;
        motion.emplace_back(all.segment<3>(3 * static_cast<Eigen::Index>(release.probes.front().node)));
    }
    return motion;
}

TEST(RelaxingRelease, RingsDownAsAStandardLinearSolidInEveryKernel) {
    for (const double tau : {0.01, 0.1, 1.0}) {
        const double modulus = 0.4;
        const PulledRod rod({"one", {modulus}, {tau}});
        const auto springs = rod.springs();
        const auto expected = exact_motion(rod, springs, modulus, tau);
        for (const auto kernel : {msm::StepKernel::scalar, msm::StepKernel::simd_double, msm::StepKernel::simd_float}) {
            const auto history = rod.motion(springs, {.time_step = 5e-4, .kernel = kernel});
            EXPECT_EQ(history.kernel, msm::to_string(kernel));
            EXPECT_LT(motion_error(history, expected), 5e-3) << history.kernel << " " << tau;
        }
    }
}

TEST(RelaxingRelease, LosesEnergyAndAddsNone) {
    const PulledRod rod({"two", {0.3, 0.3}, {0.02, 0.5}}, 0.1);
    for (const auto *name : {"nodal_springs", "nodal_neo_hookean_f"}) {
        const auto elastic = msm::coupled_springs_with_volume(*rod.problem.body, msm::find_coupled_springs(name));
        const auto history = rod.motion(elastic, {.kernel = msm::StepKernel::simd_double});
        const auto energy = [&](std::size_t k) { return history.kinetic_energy[k] + history.strain_energy[k]; };
        for (std::size_t k = 1; k < history.time.size(); ++k)
            ASSERT_LT(energy(k), energy(k - 1) + 5e-3 * energy(0)) << name << " at " << history.time[k];
        EXPECT_LT(energy(history.time.size() - 1), 0.8 * energy(0)) << name;
    }
}

TEST(RelaxingRelease, IsElasticWithEndlessTimes) {
    const PulledRod rod({"endless", {0.5}, {std::numeric_limits<double>::infinity()}}, 1.0);
    auto elastic_problem = rod.problem;
    elastic_problem.load_case.slow_history.reset();
    const auto springs = rod.springs();
    const auto followed = msm::follow_history(springs, rod.problem, springs.node_mass);
    const auto conditions =
        msm::nodal_conditions({rod.problem.body, core::without_tractions(rod.problem.load_case)}, springs.node_mass);
    const auto &points = rod.problem.body->mesh.points;
    const auto plan = msm::plan_steps(rod.problem, msm::largest_angular_frequency(springs, points, conditions), {});
    const auto expected = msm::release(elastic_problem, springs, conditions, followed.end.displacement, plan);
    EXPECT_LT(motion_error(rod.motion(springs), expected.displacement), 1e-6);
}

} // namespace
} // namespace livermark
