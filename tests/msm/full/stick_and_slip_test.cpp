#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "core/tool/touching_tool.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/statics/load_path.hpp"
#include "tests/samples/touch/sheared_column.hpp"

namespace livermark {
namespace {

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
