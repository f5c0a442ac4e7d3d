#include "msm/dynamics/release.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <set>

#include "core/support/input_error.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/springs/spring_network.hpp"
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

} // namespace

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

TEST(Release, MovesTheSameByAStabilisedMethodAsBySmallSteps) {
    const Rod rod(strong_damping());
    const auto found = rod.motion({});
    ASSERT_EQ(found.integrator, "runge_kutta_chebyshev");
    const auto expected = rod.motion(
        {.integrator = "runge_kutta_4", .time_step = 0.02 * found.time_step, .kernel = msm::StepKernel::scalar});
    ASSERT_EQ(found.displacement.size(), expected.displacement.size());
    double difference = 0.0, size = 0.0, travelled = 0.0;
    for (std::size_t i = 0; i < expected.displacement.size(); ++i) {
        difference += (found.displacement[i] - expected.displacement[i]).squaredNorm();
        size += expected.displacement[i].squaredNorm();
        travelled = std::max(travelled, (expected.displacement[i] - expected.displacement[0]).norm());
    }
    EXPECT_GT(travelled, 0.5 * expected.displacement[0].norm());
    EXPECT_LT(std::sqrt(difference / size), 1e-3);
}

} // namespace livermark
