#include <cmath>
#include <gtest/gtest.h>

#include "msm/springs/spring_network.hpp"
#include "msm/statics/load_path.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;
using Field = std::vector<Vector3>;

/// A block of springs constrained at x_min.
struct ConstrainedBlock {
    ConstrainedBlock() {
        body = tests::make_body(tests::box_mesh({0.1, 0.04, 0.05}, {6, 3, 3}), {1060.0, 5e3, 0.25});
        springs = msm::spring_network(*body, msm::all_spring_laws().front());
        load_case = tests::empty_load_case(body->mesh);
        load_case.regime = core::Regime::large;
        load_case.path = {0.3, 0.6, 1.0};
        tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
    }

    msm::FollowedPath follow() const {
        const core::Problem problem{body, load_case};
        const auto conditions = msm::nodal_conditions(problem, springs.node_mass);
        const msm::RestStiffness rest(springs, body->mesh.points, conditions.displacement);
        return msm::follow_path(springs, problem, springs.node_mass, rest);
    }

    /// Pressure that follows the surface.
    void blow(const std::string &patch, double pressure) {
        const auto &mesh = body->mesh;
        load_case.conditions.push_back({patch, core::ConditionKind::pressure});
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
            if (mesh.patch_names[mesh.boundary_patch[f]] == patch) {
                load_case.condition_on[f] = static_cast<int>(load_case.conditions.size()) - 1;
                load_case.value[f] = -pressure * core::area_vector(mesh, f).normalized();
            }
    }

    Field moved(const Field &displacement) const {
        auto positions = body->mesh.points;
        for (std::size_t i = 0; i < positions.size(); ++i)
            positions[i] += displacement[i];
        return positions;
    }

    std::shared_ptr<const core::Body> body;
    core::SpringNetwork springs;
    core::LoadCase load_case;
};

TEST(LoadPath, ComesToTheSameEquilibriaAsTheLoadsAlone) {
    ConstrainedBlock block;
    tests::pull(block.load_case, block.body->mesh, "x_max", {150.0, 60.0, -90.0});
    block.load_case.acceleration = {0.0, 1.0, 0.0};
    const auto path = block.follow();
    ASSERT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    ASSERT_EQ(path.points.size(), 3U);
    for (std::size_t k = 0; k < 3; ++k) {
        const core::Problem problem{block.body, core::scaled(block.load_case, block.load_case.path[k])};
        const auto conditions = msm::nodal_conditions(problem, block.springs.node_mass);
        const auto alone = msm::find_equilibrium(block.springs, block.body->mesh.points, conditions);
        const auto reaction = msm::constraint_forces(problem, conditions, alone.constraint_force);
        EXPECT_LT((path.points[k].reaction[0] - reaction[0]).norm(), 1e-7 * reaction[0].norm());
        double largest = 0.0;
        for (std::size_t i = 0; i < alone.displacement.size(); ++i) {
            largest = std::max(largest, alone.displacement[i].norm());
            EXPECT_LT((path.points[k].displacement[i].cast<double>() - alone.displacement[i]).norm(), 2e-8);
        }
        EXPECT_GT(largest, 0.002); // far from small
    }
}

TEST(LoadPath, PressesAsDeepAsTheWholeAtEachPartOfIt) {
    ConstrainedBlock block;
    const Vector3 direction = Vector3(1.0, 0.5, -2.0).normalized();
    tests::press(block.load_case, block.body->mesh, "x_max", direction, 0.03);
    const auto path = block.follow();
    ASSERT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    ASSERT_EQ(path.points.size(), 3U);
    double last = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        const core::Problem problem{block.body, core::scaled(block.load_case, block.load_case.path[k])};
        const auto alone = msm::find_equilibrium(block.springs, block.body->mesh.points,
                                                 msm::nodal_conditions(problem, block.springs.node_mass));
        const auto &reaction = path.points[k].reaction[1];
        EXPECT_NEAR(reaction.dot(direction), alone.press, 1e-7 * alone.press);
        EXPECT_GT(alone.press, last);
        last = alone.press;
        for (std::size_t i = 0; i < alone.displacement.size(); ++i)
            EXPECT_LT((path.points[k].displacement[i].cast<double>() - alone.displacement[i]).norm(), 2e-8);
    }
}

TEST(LoadPath, FollowerPressureBalancesTheSpringsWhereTheyAreAlsoAtItsRim) {
    ConstrainedBlock block;
    block.blow("y_max", 60.0);
    const auto path = block.follow();
    ASSERT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    const auto x = block.moved(path.end.displacement);
    const msm::SurfacePressure pressure({block.body, block.load_case});
    const auto loads = pressure.force(x);
    const auto elastic = msm::elastic_gradient(block.springs, x);
    double turned = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        if (block.body->mesh.points[i].x() > 1e-9) {
            EXPECT_LT((elastic[i] - loads[i]).norm(), 1e-6 * 60.0 * 0.1 * 0.05) << i;
        }
        turned = std::max(turned, std::abs(loads[i].x()));
    }
    EXPECT_GT(turned, 1e-4); // at rest the load has no component along the block
    Vector3 total = Vector3::Zero();
    for (const auto &load : loads)
        total += load;
    EXPECT_LT((path.points.back().reaction[0] + total).norm(), 1e-6 * total.norm());
}

TEST(LoadPath, EndsWhereThereIsNoEquilibriumAndKeepsThePointsBefore) {
    ConstrainedBlock block;
    for (const auto *const patch : {"y_min", "y_max", "z_min", "z_max", "x_max"})
        block.blow(patch, -2e4); // blown up without bound: springs soften as they turn
    block.load_case.path = {0.001, 1.0};
    const auto path = block.follow();
    EXPECT_EQ(path.end.status, core::SolutionStatus::not_converged);
    EXPECT_FALSE(path.end.message.empty());
    EXPECT_EQ(path.points.size(), 1U);
}

TEST(SurfacePressure, IsTheDerivativeOfItsEnergyButForTheRim) {
    ConstrainedBlock block;
    block.blow("y_max", 100.0);
    const msm::SurfacePressure open({block.body, block.load_case});
    for (const auto *const patch : {"x_min", "x_max", "y_min", "z_min", "z_max"})
        block.blow(patch, 100.0);
    const msm::SurfacePressure closed({block.body, block.load_case});
    Field displacement;
    for (const auto &point : block.body->mesh.points)
        displacement.push_back(0.2 * Vector3(point.y() - point.z(), std::sin(20.0 * point.x()) * 0.05, point.x()));
    const auto x = block.moved(displacement);
    for (const auto &push : closed.rim_force(x)) // a closed surface has no rim
        EXPECT_LT(push.norm(), 1e-14);
    Field gradient(x.size(), Vector3::Zero());
    open.add_gradient(x, gradient);
    constexpr double step = 1e-6;
    for (std::size_t i = 0; i < x.size(); i += 7)
        for (int c = 0; c < 3; ++c) {
            auto ahead = x, behind = x;
            ahead[i][c] += step, behind[i][c] -= step;
            EXPECT_NEAR((open.energy(ahead) - open.energy(behind)) / (2.0 * step), gradient[i][c], 1e-9);
        }
}

} // namespace
} // namespace livermark
