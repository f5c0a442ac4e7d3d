#include <gtest/gtest.h>

#include <algorithm>

#include "msm/dynamics/release.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/spring_network.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"

namespace livermark {
namespace {

using core::Vector3;

const msm::Integrator &integrator(std::string_view name) {
    return *std::ranges::find(msm::all_integrators(), name, &msm::Integrator::name);
}

struct Rod {
    core::Problem problem;
    core::SpringNetwork springs;
    msm::NodalConditions conditions;

    Rod() {
        problem.body = tests::make_body(tests::shaken_box_mesh({0.2, 0.05, 0.05}, {8, 2, 2}), {1060.0, 5000.0, 0.25});
        problem.load_case = tests::empty_load_case(problem.body->mesh);
        tests::prescribe(problem.load_case, problem.body->mesh, "x_min", {0.001, 0.0, 0.0});
        tests::pull(problem.load_case, problem.body->mesh, "x_max", {0.0, 0.0, 2.0});
        problem.load_case.acceleration = {0.0, 0.0, -0.05};
        springs = msm::spring_network(*problem.body, msm::all_spring_laws().front());
        conditions = msm::nodal_conditions(problem, springs.node_mass);
    }
};

} // namespace

TEST(DynamicRelaxation, ComesToTheEquilibriumThatNewtonFinds) {
    const Rod rod;
    const auto &points = rod.problem.body->mesh.points;
    const auto expected = msm::find_equilibrium(rod.springs, points, rod.conditions);
    ASSERT_EQ(expected.status, core::SolutionStatus::ok) << expected.message;
    for (const auto *const name : {"runge_kutta_4", "symplectic_euler", "velocity_verlet"}) {
        const auto found = msm::relax(integrator(name), rod.springs, points, rod.conditions);
        ASSERT_EQ(found.equilibrium.status, core::SolutionStatus::ok) << name << ": " << found.equilibrium.message;
        EXPECT_LT(tests::relative_difference(found.equilibrium.displacement, expected.displacement), 1e-6) << name;
        EXPECT_LT(tests::relative_difference(found.equilibrium.constraint_force, expected.constraint_force), 1e-6)
            << name;
        EXPECT_GT(found.time_step, 0.0);
    }
}

TEST(DynamicRelaxation, SaysSoWhenItIsNotAtRest) {
    const Rod rod;
    const auto found = msm::relax(integrator("runge_kutta_4"), rod.springs, rod.problem.body->mesh.points,
                                  rod.conditions, {.tolerance = 1e-9, .max_steps = 50});
    EXPECT_EQ(found.equilibrium.status, core::SolutionStatus::not_converged);
    EXPECT_NE(found.equilibrium.message.find("50 steps"), std::string::npos) << found.equilibrium.message;
}

} // namespace livermark
