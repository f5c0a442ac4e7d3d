#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <numbers>

#include "core/tool/touching_tool.hpp"
#include "msm/springs/springs.hpp"
#include "msm/statics/load_path.hpp"
#include "tests/samples/touch/sheared_column.hpp"
#include "tests/samples/touched_block.hpp"

namespace livermark {
namespace {

constexpr double young_modulus = 5e3, thickness = 0.02, radius = 0.03, depth = 2e-3;

/// Force on a rigid ball in a layer that sticks to a floor, small deformations: that of Hertz times a series in the
/// radius of contact over the thickness [N]. (Dimitriadis et al. 2002, Biophys. J. 82, equations 12 and 13)
double force_on_layer(double poisson_ratio, double sunk) {
    const double nu = poisson_ratio, pi = std::numbers::pi;
    const double a = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1.0 - nu);
    const double b = (0.6387 - 1.0277 * nu + 1.5164 * nu * nu) / (1.0 - nu);
    const double chi = std::sqrt(radius * sunk) / thickness;
    const double hertz = 4.0 / 3.0 * young_modulus / (1.0 - nu * nu) * std::sqrt(radius) * std::pow(sunk, 1.5);
    return hertz * (1.0 - 2.0 * a / pi * chi + std::pow(2.0 * a / pi * chi, 2) -
                    8.0 / std::pow(pi, 3) * (std::pow(a, 3) + 4.0 * pi * pi / 15.0 * b) * std::pow(chi, 3) +
                    16.0 * a / std::pow(pi, 4) * (std::pow(a, 3) + 3.0 * pi * pi / 5.0 * b) * std::pow(chi, 4));
}

double force_of_springs(int bricks_across, int bricks_down, double sunk) {
    tests::TouchedBlock block;
    block.size = {0.06, 0.06, thickness};
    block.bricks = {bricks_across, bricks_across, bricks_down};
    block.shape = radius;
    block.press = {0.0, 0.0, -sunk};
    block.path = {0.5, 1.0};
    const auto problem = tests::touched_block(block);
    const auto springs =
        msm::coupled_springs_with_volume(*problem.body, msm::find_coupled_springs("nodal_neo_hookean"));
    const auto conditions = msm::nodal_conditions(problem, springs.node_mass);
    const msm::RestStiffness rest(springs, problem.body->mesh.points, conditions.displacement);
    const auto path = msm::follow_path(springs, problem, springs.node_mass, rest);
    EXPECT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    return -path.points.back().reaction.back().z();
}

double error_of_springs(int bricks_across, int bricks_down, double sunk) {
    const double force = force_of_springs(bricks_across, bricks_down, sunk), expected = force_on_layer(0.3, sunk);
    const double error = force / expected - 1.0;
    fmt::print("{} tetrahedra, {:.1f} mm: {:.4f} N, {:+.1f} % from {:.4f} N\n",
               6 * bricks_across * bricks_across * bricks_down, 1e3 * sunk, force, 100.0 * error, expected);
    return error;
}

TEST(TouchedLayer, OfCoupledSpringsConvergesToTheClosedForm) {
    const double coarse = error_of_springs(9, 3, depth), fine = error_of_springs(18, 6, depth);
    EXPECT_LT(std::abs(coarse), 0.08);
    EXPECT_LT(std::abs(fine), 0.03);
    EXPECT_LT(std::abs(fine), 0.5 * std::abs(coarse));
}

/// A circle of contact of half an edge: points on facets miss a fifth of the force at most, and a twentieth where it is
/// an edge.
TEST(TouchedLayer, OnFacetsBearsABallThatIsBetweenNodes) {
    const double shallow = 0.25 * depth;
    EXPECT_LT(std::abs(error_of_springs(9, 3, shallow)), 0.2);
    EXPECT_LT(std::abs(error_of_springs(18, 6, shallow)), 0.05);
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
    const auto without_penalty = found.shear.problem({3, 3, 1}, 1.0, beyond);
    const auto facets = core::touched_facets(*without_penalty.body, without_penalty.load_case);
    const auto problem = found.shear.problem({3, 3, 1}, facets.front().penalty, beyond);
    const auto springs = msm::coupled_springs_with_volume(*problem.body, msm::find_coupled_springs(name));
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
