#include <cmath>
#include <gtest/gtest.h>

#include "msm/springs/coupled_springs.hpp"
#include "msm/springs/spring_network.hpp"
#include "msm/statics/load_path.hpp"
#include "msm/statics/surface_contact.hpp"
#include "tests/samples/touched_block.hpp"

namespace livermark {
namespace {

using core::Vector3;
using Field = std::vector<Vector3>;

Field positions_of(const core::Problem &problem, const Field &displacement) {
    auto positions = problem.body->mesh.points;
    for (std::size_t i = 0; i < positions.size(); ++i)
        positions[i] += displacement[i];
    return positions;
}

/// Nodes here and there, some inside a ball that has come.
Field bumpy(const core::Problem &problem) {
    auto positions = problem.body->mesh.points;
    for (std::size_t i = 0; i < positions.size(); ++i)
        positions[i] += 1e-3 * Vector3(std::sin(3.0 * static_cast<double>(i)), std::cos(5.0 * static_cast<double>(i)),
                                       std::sin(7.0 * static_cast<double>(i)));
    return positions;
}

struct Touched {
    explicit Touched(const tests::TouchedBlock &block, const char *springs = nullptr)
        : problem(tests::touched_block(block)),
          body(springs ? msm::coupled_springs_with_volume(*problem.body, msm::find_coupled_springs(springs))
                       : msm::ElasticBody(msm::spring_network(*problem.body, msm::all_spring_laws().front()))) {
        const auto conditions = msm::nodal_conditions(problem, body.node_mass);
        const msm::RestStiffness rest(body, problem.body->mesh.points, conditions.displacement);
        path = msm::follow_path(body, problem, body.node_mass, rest);
        EXPECT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    }

    Vector3 force() const { return path.points.back().reaction.back(); }
    /// From the centre of the ball.
    double nearest() const {
        const auto centre = problem.load_case.touching->centre_at(1.0);
        double least = 1e300;
        for (const auto &x : positions_of(problem, path.end.displacement))
            least = std::min(least, (x - centre).norm());
        return least;
    }

    core::Problem problem;
    msm::ElasticBody body;
    msm::FollowedPath path;
};

TEST(SurfaceContact, HasAnEnergyWhoseDerivativesAreItsForcesAndItsHessian) {
    tests::TouchedBlock block;
    block.friction = 0.4;
    const auto problem = tests::touched_block(block);
    msm::SurfaceContact contact(problem);
    contact.move_ball(1.0);
    auto x = bumpy(problem);
    contact.update(x); // with multipliers and bounds of friction that are not zero
    for (auto &point : x)
        point += Vector3(4e-4, -2e-4, 1e-4);
    Field gradient(x.size(), Vector3::Zero());
    contact.add_gradient(x, gradient);
    const auto hessian = contact.hessian(x, msm::Tangent::exact);
    constexpr double h = 1e-7;
    int num_touched = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            auto more = x, less = x;
            more[i][c] += h;
            less[i][c] -= h;
            const double slope = (contact.energy(more) - contact.energy(less)) / (2.0 * h);
            EXPECT_NEAR(slope, gradient[i][c], 1e-6 + 1e-5 * std::abs(slope));
            num_touched += slope != 0.0 ? 1 : 0;
            Field up(x.size(), Vector3::Zero()), down = up;
            contact.add_gradient(more, up);
            contact.add_gradient(less, down);
            for (int r = 0; r < 3; ++r) {
                const double column = (up[i][r] - down[i][r]) / (2.0 * h);
                const auto row = static_cast<Eigen::Index>(3 * i) + r, at = static_cast<Eigen::Index>(3 * i) + c;
                EXPECT_NEAR(column, hessian.coeff(row, at), 1e-3 + 1e-4 * std::abs(column));
            }
        }
    EXPECT_GT(num_touched, 20);
    const Eigen::VectorXd u = Eigen::VectorXd::LinSpaced(hessian.rows(), -1.0, 2.0);
    Eigen::VectorXd product = Eigen::VectorXd::Zero(u.size());
    contact.add_hessian_product(x, u, product);
    EXPECT_LT((product - hessian * u).norm(), 1e-12 * product.norm());
    Vector3 sum = Vector3::Zero();
    for (const auto &force : gradient)
        sum -= force;
    EXPECT_LT((sum - contact.force(x)).norm(), 1e-12 * sum.norm());
}

/// What the ball exerts the floor bears; no node is inside the ball; it pushes and does not pull.
TEST(SurfaceContact, IsBorneByWhatHoldsTheBody) {
    for (const char *springs : {static_cast<const char *>(nullptr), "nodal_neo_hookean"}) {
        const Touched touched({}, springs);
        ASSERT_EQ(touched.path.points.size(), 4U);
        double before = 0.0;
        for (const auto &point : touched.path.points) {
            EXPECT_LT((point.reaction[0] + point.reaction[1]).norm(), 1e-6 * point.reaction[1].norm());
            EXPECT_LT(point.reaction[1].z(), before);
            before = point.reaction[1].z();
        }
        EXPECT_GT(touched.nearest(), 0.02 - 1e-8);
        EXPECT_LT(touched.nearest(), 0.02 + 1e-8);
        // As the depth to a power of 1.5 where the block is large, and more where its floor is near.
        const double power = std::log(touched.force().z() / touched.path.points[1].reaction[1].z()) / std::log(2.0);
        EXPECT_GT(power, 1.3);
        EXPECT_LT(power, 2.2);
    }
}

TEST(SurfaceContact, DoesNotDependOnThePenalty) {
    const auto problem = tests::touched_block();
    const auto body = msm::ElasticBody(msm::spring_network(*problem.body, msm::all_spring_laws().front()));
    const auto conditions = msm::nodal_conditions(problem, body.node_mass);
    const msm::RestStiffness rest(body, problem.body->mesh.points, conditions.displacement);
    const auto with = [&](double stiffness) {
        return msm::follow_path(body, problem, body.node_mass, rest, stiffness).points.back().reaction.back();
    };
    const Vector3 soft = with(3.0), hard = with(30.0);
    EXPECT_GT(soft.norm(), 0.01);
    EXPECT_LT((soft - hard).norm(), 2e-5 * hard.norm());
}

/// A ball that comes down obliquely: friction resists its slide, as far as the cone goes.
TEST(SurfaceContact, KeepsFrictionWithinItsCone) {
    tests::TouchedBlock block;
    block.press = {4e-3, 0.0, -3e-3};
    const auto along = [&](double friction) {
        block.friction = friction;
        const auto force = Touched(block).force();
        return -force.x() / force.z();
    };
    const double none = along(0.0), some = along(0.2), much = along(3.0);
    EXPECT_NEAR(none, 0.0, 0.1); // the shape of what it sinks into
    EXPECT_GT(some, none + 0.1);
    EXPECT_LT(some, none + 0.25);
    EXPECT_GT(much, 2.0 * some); // it sticks
}

} // namespace
} // namespace livermark
