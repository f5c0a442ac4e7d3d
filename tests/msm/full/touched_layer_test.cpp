#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/tool/touching_tool.hpp"
#include "msm/springs/springs.hpp"
#include "msm/statics/load_path.hpp"
#include "tests/samples/touch/sheared_column.hpp"
#include "tests/samples/touch/touched_layer.hpp"

namespace livermark {
namespace {

constexpr double depth = 2e-3; // m

double force_of_springs(int bricks_down, double sunk) {
    const auto problem = tests::TouchedLayer{.bricks_down = bricks_down}.problem(sunk);
    const auto springs =
        msm::coupled_springs_with_volume(*problem.body, msm::find_coupled_springs("nodal_neo_hookean"));
    const auto conditions = msm::nodal_conditions(problem, springs.node_mass);
    const msm::RestStiffness rest(springs, problem.body->mesh.points, conditions.displacement);
    const auto path = msm::follow_path(springs, problem, springs.node_mass, rest);
    EXPECT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    return -path.points.back().reaction.back().z();
}

double error_of_springs(int bricks_down, double sunk) {
    const double force = force_of_springs(bricks_down, sunk), expected = tests::TouchedLayer::force(0.3, sunk);
    const double error = force / expected - 1.0;
    fmt::print("{} tetrahedra, {:.1f} mm: {:.4f} N, {:+.1f} % from {:.4f} N\n",
               54 * bricks_down * bricks_down * bricks_down, 1e3 * sunk, force, 100.0 * error, expected);
    return error;
}

TEST(TouchedLayer, OfCoupledSpringsConvergesToTheClosedForm) {
    const double coarse = error_of_springs(3, depth), fine = error_of_springs(6, depth);
    EXPECT_LT(std::abs(coarse), 0.08);
    EXPECT_LT(std::abs(fine), 0.03);
    EXPECT_LT(std::abs(fine), 0.5 * std::abs(coarse));
}

/// A circle of contact of half an edge, and of an edge.
TEST(TouchedLayer, OnFacetsBearsABallThatIsBetweenNodes) {
    const double shallow = 0.25 * depth;
    EXPECT_LT(std::abs(error_of_springs(3, shallow)), 0.2);
    EXPECT_LT(std::abs(error_of_springs(6, shallow)), 0.05);
}

using core::Vector3;

struct ShearedSprings {
    tests::SimpleShear shear;
    Vector3 force = Vector3::Zero();
    double tilt = 0.0; ///< of the normal of the ball that stands for the flat, which has gone ahead of the column
    double largest_difference = 0.0; ///< of a node from the closed form, over the largest displacement
};

ShearedSprings shear_springs(const char *name, double part_of_slip, double beyond) {
    ShearedSprings found{.shear = tests::SimpleShear(part_of_slip)};
    const auto without_penalty = found.shear.problem({3, 3, 1}, {1.0, 1.0}, beyond);
    auto springs = msm::coupled_springs_with_volume(*without_penalty.body, msm::find_coupled_springs(name));
    springs.softness = {}; // the flat is a ball that facets have to let in by more than it is round
    const auto facet = core::touched_facets(*without_penalty.body, without_penalty.load_case).front();
    const auto problem = found.shear.problem({3, 3, 1}, {facet.penalty(0.0), facet.tangential_penalty()}, beyond);
    const auto conditions = msm::nodal_conditions(problem, springs.node_mass);
    const msm::RestStiffness rest(springs, problem.body->mesh.points, conditions.displacement);
    const auto path = msm::follow_path(springs, problem, springs.node_mass, rest);
    EXPECT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    if (path.points.empty())
        return found;
    found.force = path.points.back().reaction.back();
    const auto &ball = *problem.load_case.touching;
    found.tilt =
        (ball.press.x() - found.shear.displacement({0.0, 0.0, tests::SimpleShear::height}).x()) / ball.shape.radius;
    const auto &points = problem.body->mesh.points;
    for (std::size_t i = 0; i < points.size(); ++i)
        found.largest_difference =
            std::max(found.largest_difference, (path.end.displacement[i] - found.shear.displacement(points[i])).norm());
    found.largest_difference /= found.shear.displacement({0.0, 0.0, tests::SimpleShear::height}).norm();
    return found;
}

constexpr const char *families[] = {"nodal_neo_hookean", "nodal_neo_hookean_f", "edge_neo_hookean_f"};

TEST(SpringsStickAndSlip, AColumnSticksBelowTheConeOfFriction) {
    for (const char *const name : families) {
        const auto found = shear_springs(name, 0.5, 1.0);
        EXPECT_NEAR(found.force.x() / found.shear.shear_force(), 1.0, 0.005) << name;
        EXPECT_NEAR(-found.force.z() / found.shear.normal_force(), 1.0, 0.005) << name;
        EXPECT_NEAR(found.force.x() / -found.force.z(), 0.5 * tests::SimpleShear::friction, 0.002) << name;
        EXPECT_LT(found.largest_difference, 0.002) << name;
    }
}

TEST(SpringsStickAndSlip, AColumnSlipsWithTheForceOfTheCone) {
    for (const char *const name : families) {
        const auto found = shear_springs(name, 1.0, 2.0);
        EXPECT_NEAR(found.force.x() / -found.force.z(), std::tan(std::atan(tests::SimpleShear::friction) - found.tilt),
                    1e-5)
            << name;
        EXPECT_NEAR(found.force.x() / found.shear.shear_force(), 1.0, 0.005) << name;
        EXPECT_LT(found.largest_difference, 0.002) << name;
    }
}

} // namespace
} // namespace livermark
