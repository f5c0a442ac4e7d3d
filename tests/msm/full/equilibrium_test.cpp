#include <cmath>
#include <gtest/gtest.h>

#include "msm/springs/springs.hpp"
#include "msm/statics/equilibrium.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

struct Block {
    core::Problem problem;
    core::SpringNetwork springs;
    msm::NodalConditions conditions;

    msm::Equilibrium found(const msm::EquilibriumOptions &options = {}) const {
        return msm::find_equilibrium(springs, problem.body->mesh.points, conditions, options);
    }
};

/// A block constrained at x_min, pulled at x_max, and under an acceleration.
Block pulled_block(const Vector3 &traction, const Vector3 &acceleration) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.04, 0.05}, {5, 2, 3}), {1060.0, 5e3, 0.25});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
    tests::pull(load_case, body->mesh, "x_max", traction);
    tests::pull(load_case, body->mesh, "y_max", 0.3 * traction); // shares nodes with the constrained facets
    load_case.acceleration = acceleration;
    auto springs = msm::spring_network(*body, msm::all_spring_laws().front());
    Block block{{body, std::move(load_case)}, std::move(springs), {}};
    block.conditions = msm::nodal_conditions(block.problem, block.springs.node_mass);
    return block;
}

Vector3 total(const std::vector<Vector3> &forces) {
    Vector3 result = Vector3::Zero();
    for (const auto &force : forces)
        result += force;
    return result;
}

/// Forces, and moments about the deformed positions.
TEST(Equilibrium, BalancesForcesAndMoments) {
    const auto block = pulled_block({40.0, 10.0, -20.0}, {0.1, 0.3, -0.2});
    const auto result = block.found();
    ASSERT_EQ(result.status, core::SolutionStatus::ok) << result.message;
    const Vector3 load = total(block.conditions.force);
    const auto reactions = msm::constraint_forces(block.problem, block.conditions, result.constraint_force);
    EXPECT_LT((total(reactions) + load).norm(), 1e-9 * load.norm());
    const auto positions = msm::moved(block.problem.body->mesh.points, result.displacement);
    Vector3 moment = Vector3::Zero();
    double scale = 0.0;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const Vector3 force = block.conditions.force[i] + result.constraint_force[i];
        moment += positions[i].cross(force);
        scale += 0.1 * force.norm();
    }
    EXPECT_LT(moment.norm(), 1e-9 * scale);
}

/// A place that presses to a depth is a load: the one that it reports. Far from small, whatever stands in for the
/// inverse.
TEST(Equilibrium, OfWhatPressesIsThatUnderItsForce) {
    const double depth = 0.02;
    const Vector3 direction = Vector3(2.0, 1.0, -3.0).normalized();
    auto block = pulled_block(Vector3::Zero(), Vector3::Zero());
    const auto &[body, held] = block.problem;
    auto pressed = core::without_tractions(held), pulled = pressed;
    tests::press(pressed, body->mesh, "x_max", direction, depth);
    const auto coupled = msm::coupled_springs_with_volume(*body, msm::find_coupled_springs("nodal_neo_hookean"));
    const auto check = [&](const msm::ElasticBody &springs, const char *name) {
        SCOPED_TRACE(name);
        const auto at_depth = msm::nodal_conditions({body, pressed}, springs.node_mass);
        const auto result = msm::find_equilibrium(springs, body->mesh.points, at_depth);
        ASSERT_EQ(result.status, core::SolutionStatus::ok) << result.message;
        EXPECT_GT(result.press, 0.0);
        double reached = 0.0;
        for (std::size_t i = 0; i < at_depth.force.size(); ++i)
            reached += at_depth.force[i].dot(result.displacement[i]);
        EXPECT_NEAR(reached, depth, 1e-9 * depth);
        const auto reactions = msm::constraint_forces({body, pressed}, at_depth, result.constraint_force, result.press);
        EXPECT_LT((reactions[1] - result.press * direction).norm(), 1e-12 * result.press);
        EXPECT_LT(total(reactions).norm(), 1e-8 * result.press);
        tests::pull(pulled, body->mesh, "x_max", result.press / (0.04 * 0.05) * direction);
        const auto loaded = msm::nodal_conditions({body, pulled}, springs.node_mass);
        const auto expected = msm::find_equilibrium(springs, body->mesh.points, loaded);
        ASSERT_EQ(expected.status, core::SolutionStatus::ok) << expected.message;
        EXPECT_LT(tests::relative_difference(result.displacement, expected.displacement), 1e-7);
        EXPECT_GT(tests::relative_difference(result.displacement, result.linear_displacement), 0.02);
    };
    check(block.springs, "central springs");
    check(coupled, "springs with an approximate factor");
}

/// Under loads so small that rounding of the positions is all that is left long before the tolerance is met.
TEST(Equilibrium, IsFoundUnderLoadsNearRounding) {
    for (const double load : {1e-3, 1e-5, 1e-7}) {
        const auto block = pulled_block({load, 0.0, 0.0}, Vector3::Zero());
        const auto result = block.found();
        EXPECT_EQ(result.status, core::SolutionStatus::ok) << load << ": " << result.message;
        EXPECT_LT(result.num_iterations, 10) << load;
        EXPECT_LT(tests::relative_difference(result.displacement, result.linear_displacement), 1e-4) << load;
    }
}

TEST(Equilibrium, ApproachesTheLinearSolutionInProportionToTheLoad) {
    const auto relative_nonlinearity = [](double load) {
        const auto block = pulled_block({load, 0.0, -load}, Vector3::Zero());
        const auto result = block.found();
        EXPECT_EQ(result.status, core::SolutionStatus::ok) << result.message;
        return tests::relative_difference(result.linear_displacement, result.displacement);
    };
    EXPECT_NEAR(relative_nonlinearity(2.0) / relative_nonlinearity(1.0), 2.0, 0.1);
}

TEST(Equilibrium, FollowsAPrescribedDisplacementWithoutLoads) {
    auto block = pulled_block(Vector3::Zero(), Vector3::Zero());
    auto &load_case = block.problem.load_case;
    tests::prescribe(load_case, block.problem.body->mesh, "x_max", {0.01, 0.0, 0.0});
    block.conditions = msm::nodal_conditions(block.problem, block.springs.node_mass);
    const auto result = block.found();
    ASSERT_EQ(result.status, core::SolutionStatus::ok) << result.message;
    const auto reactions = msm::constraint_forces(block.problem, block.conditions, result.constraint_force);
    ASSERT_EQ(reactions.size(), 2U);
    EXPECT_GT(reactions[1].x(), 0.0);
    EXPECT_LT((reactions[0] + reactions[1]).norm(), 1e-9 * reactions[1].norm());
}

/// A rod constrained at its lower end, and pressed at the other along its axis by loads that keep their direction.
struct PressedRod {
    std::shared_ptr<const core::Body> body =
        tests::make_body(tests::shaken_box_mesh({0.02, 0.02, 0.2}, {2, 2, 20}), {1060.0, 5e3, 0.25});
    core::SpringNetwork springs = msm::spring_network(*body, msm::all_spring_laws().front());
    /// Euler's load of a rod constrained at one end: pi^2 E I / (4 L^2), here as a pressure.
    static constexpr double euler_pressure = 10.3; // Pa

    msm::NodalConditions pressed_by(double pressure) const {
        auto load_case = tests::empty_load_case(body->mesh);
        tests::prescribe(load_case, body->mesh, "z_min", Vector3::Zero());
        tests::pull(load_case, body->mesh, "z_max", {0.0, 0.0, -pressure});
        return msm::nodal_conditions({body, load_case}, springs.node_mass);
    }
    double sideways_at_top(const msm::Equilibrium &found) const {
        double largest = 0.0;
        for (std::size_t i = 0; i < found.displacement.size(); ++i)
            largest = std::max(largest, found.displacement[i].head<2>().norm());
        return largest;
    }
};

/// Beyond Euler's load the straight rod is a saddle of the energy. The way from there leads along a direction that
/// bends downwards, where Newton's method without the negative part of the second derivative does not arrive in 60
/// steps.
msm::Equilibrium expect_to_buckle(const PressedRod &rod, const msm::ElasticBody &body, int max_iterations) {
    const auto &points = rod.body->mesh.points;
    const auto straight = msm::find_equilibrium(body, points, rod.pressed_by(0.5 * PressedRod::euler_pressure));
    EXPECT_EQ(straight.status, core::SolutionStatus::ok) << straight.message;
    EXPECT_LT(rod.sideways_at_top(straight), 0.01);

    const auto conditions = rod.pressed_by(2.0 * PressedRod::euler_pressure);
    auto buckled = msm::find_equilibrium(body, points, conditions, {.max_iterations = max_iterations});
    EXPECT_EQ(buckled.status, core::SolutionStatus::ok) << buckled.message;
    EXPECT_GT(rod.sideways_at_top(buckled), 0.05);

    const auto there = msm::moved(points, buckled.displacement);
    const msm::FreeComponents free(conditions.displacement);
    const auto tangent = free.restrict(msm::elastic_hessian(body, there, msm::Tangent::exact));
    support::SparseCholesky factor;
    factor.order(tangent);
    EXPECT_TRUE(factor.factorise(tangent)) << "it rests on a saddle";
    return buckled;
}

TEST(Equilibrium, FollowsARodThatBucklesToItsRest) {
    const PressedRod rod;
    EXPECT_LT(expect_to_buckle(rod, rod.springs, msm::EquilibriumOptions{}.max_iterations).num_factors, 30);
}

TEST(Equilibrium, FollowsARodThatBucklesWithThePreconditionerAlone) {
    const PressedRod rod;
    for (const auto *name : {"nodal_neo_hookean", "edge_neo_hookean", "nodal_neo_hookean_f"}) {
        SCOPED_TRACE(name);
        const auto body = msm::coupled_springs_with_volume(*rod.body, msm::find_coupled_springs(name));
        EXPECT_TRUE(body.preconditioner);
        // Edges take about 300 steps, a few more or less with the rounding of a machine's factors.
        EXPECT_EQ(expect_to_buckle(rod, body, 2 * msm::EquilibriumOptions{}.max_iterations).num_factors, 0);
    }
}

TEST(Equilibrium, IsTheSameWithTheFactorThatAnotherLoadLeft) {
    const auto block = pulled_block({40.0, 10.0, -20.0}, {0.1, 0.3, -0.2});
    const auto other = pulled_block({0.0, 5.0, 0.0}, Vector3::Zero());
    const auto &points = block.problem.body->mesh.points;
    const msm::RestStiffness rest(other.springs, points, other.conditions.displacement);
    ASSERT_TRUE(rest.constrains(block.conditions.displacement));
    const auto expected = msm::find_equilibrium(block.springs, points, block.conditions);
    const auto found = msm::find_equilibrium(block.springs, points, block.conditions, rest);
    EXPECT_EQ(found.displacement, expected.displacement);
    EXPECT_EQ(found.num_iterations, expected.num_iterations);
}

TEST(Equilibrium, IsTheSameWithAFactorOfFewerConstraints) {
    auto block = pulled_block({40.0, 10.0, -20.0}, {0.1, 0.3, -0.2});
    const auto &points = block.problem.body->mesh.points;
    const auto common = block.conditions.displacement;
    auto &prescribed = block.conditions.displacement.back();
    ASSERT_TRUE(prescribed.array().isNaN().all());
    prescribed.y() = 0.002;
    auto shared = msm::RestStiffness::shared(block.springs, points, common);
    shared.constrain(block.conditions.displacement);
    ASSERT_TRUE(shared.is_definite());
    EXPECT_TRUE(shared.constrains(block.conditions.displacement));
    EXPECT_FALSE(shared.constrains(common));
    const msm::RestStiffness own(block.springs, points, block.conditions.displacement);
    EXPECT_EQ(shared.rounding_force(), own.rounding_force());
    const auto expected = msm::find_equilibrium(block.springs, points, block.conditions, own);
    const auto found = msm::find_equilibrium(block.springs, points, block.conditions, shared);
    ASSERT_EQ(found.status, core::SolutionStatus::ok) << found.message;
    EXPECT_LT(tests::relative_difference(found.linear_displacement, expected.linear_displacement), 1e-11);
    EXPECT_NE(found.linear_displacement, expected.linear_displacement) << "it was not the shared factor";
    EXPECT_LT(tests::relative_difference(found.displacement, expected.displacement), 1e-10);
    EXPECT_EQ(found.num_iterations, expected.num_iterations);
    EXPECT_EQ(found.displacement.back().y(), 0.002);
}

TEST(Equilibrium, KnowsThatAFactorIsOfOtherConstraints) {
    const auto block = pulled_block({40.0, 10.0, -20.0}, Vector3::Zero());
    const msm::RestStiffness rest(block.springs, block.problem.body->mesh.points, block.conditions.displacement);
    auto moved = block.conditions.displacement;
    auto fewer = moved;
    for (auto &node : moved)
        node *= 2.0;
    EXPECT_TRUE(rest.constrains(moved)) << "values do not matter";
    for (auto &node : fewer)
        node.x() = std::nan("");
    EXPECT_FALSE(rest.constrains(fewer));
}

TEST(Equilibrium, SaysSoWhereNothingHoldsTheBody) {
    auto block = pulled_block({1.0, 0.0, 0.0}, Vector3::Zero());
    block.conditions.displacement.assign(block.conditions.displacement.size(), Vector3::Constant(std::nan("")));
    const auto result = block.found();
    EXPECT_EQ(result.status, core::SolutionStatus::not_converged);
    EXPECT_NE(result.message.find("constrain more facets"), std::string::npos) << result.message;
}

TEST(Equilibrium, SaysSoWhereTheIterationsRunOut) {
    const auto block = pulled_block({40.0, 10.0, -20.0}, Vector3::Zero());
    const auto result = block.found({.tolerance = 1e-11, .max_iterations = 1});
    EXPECT_EQ(result.status, core::SolutionStatus::not_converged);
    EXPECT_NE(result.message.find("after 1 steps"), std::string::npos) << result.message;
}

} // namespace
} // namespace livermark
