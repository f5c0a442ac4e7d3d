#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <random>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/tool/ball_contact.hpp"
#include "core/tool/tool_motion.hpp"
#include "tests/samples/touched_block.hpp"

namespace livermark {
namespace {

using core::Vector3;

class RandomPoints {
  public:
    Vector3 near(const Vector3 &middle, double reach) {
        return middle + reach * Vector3(component_(random_), component_(random_), component_(random_));
    }

  private:
    std::mt19937 random_{7};
    std::uniform_real_distribution<double> component_{-1.0, 1.0};
};

const Eigen::Matrix3d soft = 0.5 * Eigen::Matrix3d::Identity(); // [m/N]

TEST(BallForce, PutsPointsOutOfTheBallAndLeavesOthersWhereTheyAre) {
    RandomPoints points;
    for (const double friction : {0.0, 0.3, 10.0})
        for (int k = 0; k < 200; ++k) {
            const core::BallStep ball{Vector3::Zero(), points.near({0, 0, 0}, 0.1), 1.0, friction};
            const auto start = points.near({0, 0, 1}, 0.2), now = points.near({0, 0, 1}, 0.2);
            const Vector3 force = core::ball_force(ball, start, now, Vector3::Zero(), soft);
            const bool is_inside = (now - ball.to).norm() < 1.0;
            EXPECT_EQ(force == Vector3::Zero(), !is_inside);
            EXPECT_GE((now + soft * force - ball.to).norm(), 1.0 - 1e-12);
        }
}

TEST(BallForce, PutsPointsOutOfPlates) {
    RandomPoints points;
    for (const auto face : {core::ToolFace::round, core::ToolFace::square})
        for (const double friction : {0.0, 0.3})
            for (int k = 0; k < 200; ++k) {
                const core::ToolShape plate(face, 1.0, 0.2, {0.1, -0.2, 1.0});
                const core::BallStep step{Vector3::Zero(), points.near({0, 0, 0}, 0.1), plate, friction};
                const auto start = points.near({0.6, 0, 0.5}, 0.8), now = points.near({0.6, 0, 0.2}, 0.8);
                const auto gap = core::gap_to(plate, now - step.to);
                const Vector3 force = core::ball_force(step, start, now, Vector3::Zero(), soft);
                EXPECT_EQ(force == Vector3::Zero(), gap.size >= 0.0);
                const double inwards = force.dot(gap.normal);
                EXPECT_GE((now + soft * force - step.to).dot(gap.normal) - (now - step.to).dot(gap.normal) + gap.size,
                          -1e-12);
                EXPECT_GE(inwards, 0.0);
                EXPECT_LE((force - inwards * gap.normal).norm(), friction * inwards + 1e-12);
            }
}

/// It never pulls, and friction is within its cone and against the way along the ball.
TEST(BallForce, KeepsToTheConeOfFriction) {
    RandomPoints points;
    int num_sticking = 0, num_slipping = 0;
    for (const double friction : {0.0, 0.3, 2.0})
        for (int k = 0; k < 300; ++k) {
            const core::BallStep ball{Vector3::Zero(), points.near({0, 0, 0}, 0.05), 1.0, friction};
            const auto start = points.near({0, 0, 1}, 0.1), now = points.near({0, 0, 0.95}, 0.1);
            const auto before = k % 2 == 0 ? Vector3(Vector3::Zero()) : points.near({0, 0, 0}, 0.1);
            const Vector3 force = core::ball_force(ball, start, now, before, soft);
            const Vector3 normal = (now - ball.to).normalized();
            const double inwards = force.dot(normal);
            const Vector3 along = force - inwards * normal;
            EXPECT_GE(inwards, 0.0);
            EXPECT_LE(along.norm(), friction * inwards + 1e-12);
            if (inwards == 0.0)
                continue;
            const Vector3 way = now + soft * (force - before) - start - ball.to;
            const double rest = (way - way.dot(normal) * normal).norm();
            num_sticking += rest < 1e-12 ? 1 : 0;
            if (rest > 1e-9 && friction > 0.0) {
                ++num_slipping;
                EXPECT_NEAR(along.norm(), friction * inwards, 1e-12);
            }
        }
    EXPECT_GT(num_sticking, 20);
    EXPECT_GT(num_slipping, 20);
}

/// Iterations take back what they have pushed too much.
TEST(BallForce, TakesBackWhatWasTooMuch) {
    const core::BallStep ball{Vector3::Zero(), Vector3::Zero(), 1.0, 0.0};
    const Vector3 start(0, 0, 1.0), before(0, 0, 0.4);
    EXPECT_NEAR(core::ball_force(ball, start, {0, 0, 1.05}, before, soft).z(), 0.3, 1e-15);
    EXPECT_EQ(core::ball_force(ball, start, {0, 0, 1.3}, before, soft), Vector3::Zero());
    EXPECT_NEAR(core::ball_force(ball, start, {0, 0, 0.9}, before, soft).z(), 0.6, 1e-15);
    EXPECT_EQ(core::ball_force(ball, start, {0, 0, 0.9}, before, Eigen::Matrix3d::Zero()), Vector3::Zero());
}

/// Iterated until it stays: the conditions of contact hold, with a stiffness in between, and without friction the point
/// is inside the ball by compliance times force.
TEST(BallForce, EndsWhereForcesBalanceWithinTheCone) {
    RandomPoints points;
    int num_touched = 0, num_slipping = 0;
    for (const double friction : {0.0, 0.3})
        for (const double compliance : {0.0, 0.1})
            for (int k = 0; k < 100; ++k) {
                const core::BallStep ball{Vector3::Zero(), points.near({0, 0, 0}, 0.02), 1.0, friction};
                const auto start = Vector3(points.near({0, 0, 1}, 0.1).normalized());
                const auto minimum = points.near({0, 0, 0.97}, 0.1);
                Eigen::Matrix3d root;
                root << points.near({1, 0, 0}, 0.3), points.near({0, 2, 0}, 0.3), points.near({0, 0, 1}, 0.3);
                const Eigen::Matrix3d yields = (root * root.transpose()).inverse();
                Vector3 force = Vector3::Zero(), now = minimum;
                for (int iteration = 0; iteration < 400; ++iteration) {
                    force = core::ball_force(ball, start, now, force, yields, compliance);
                    now = minimum + yields * force;
                }
                const Vector3 out = now - ball.to;
                if (force.isZero(0.0)) {
                    EXPECT_GE((minimum - ball.to).norm(), 1.0);
                    continue;
                }
                ++num_touched;
                const double inwards = force.dot(out.normalized());
                const double along = (force - inwards * out.normalized()).norm();
                EXPECT_GT(inwards, 0.0);
                if (friction == 0.0) {
                    EXPECT_NEAR(1.0 - out.norm(), compliance * inwards, 1e-6);
                }
                EXPECT_LE(along, friction * inwards + 1e-6);
                num_slipping += friction > 0.0 && along > 0.999 * friction * inwards ? 1 : 0;
            }
    EXPECT_GT(num_touched, 100);
    EXPECT_GT(num_slipping, 10);
}

TEST(BallContact, GoesWhereTheToolGoes) {
    const auto problem = tests::slid_block();
    const auto &ball = *problem.load_case.touching;
    const auto &motion = *problem.load_case.tool;
    EXPECT_EQ(core::ball_centre(ball, motion, 0.0), ball.start);
    EXPECT_LT((core::ball_centre(ball, motion, 0.11) - ball.start - ball.press).norm(), 1e-15);
    EXPECT_LT((core::ball_centre(ball, motion, 0.3) - ball.start - ball.press - motion.slide).norm(), 1e-15);
    core::BallContact contact({}, 1, 1.0, 0.2);
    contact.set_way({0, 0, 0}, {0, 0, 3});
    EXPECT_LT((contact.part(1, 3).from - Vector3(0, 0, 1)).norm(), 1e-15);
    EXPECT_LT((contact.part(1, 3).to - Vector3(0, 0, 2)).norm(), 1e-15);
    EXPECT_EQ(contact.part(2, 3).to, Vector3(0, 0, 3));
}

TEST(BallContact, SeesAllFacetsThatItMayMeet) {
    const auto problem = tests::slid_block();
    const auto &mesh = problem.body->mesh;
    core::BallContact contact(core::touched_facets(*problem.body, problem.load_case), 1, 0.02, 0.0);
    ASSERT_FALSE(contact.nodes().empty());
    const auto &ball = *problem.load_case.touching;
    contact.set_way(ball.start, ball.start + ball.press);
    contact.look_around([&](int node) { return mesh.points[node]; });
    EXPECT_LT(contact.near().size(), contact.nodes().size());
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        const auto &nodes = mesh.boundary_triangles[f];
        const auto corners = core::corners_of(mesh, f);
        const Vector3 centre = ball.start + ball.press;
        if (problem.load_case.may_touch(f) &&
            (core::nearest_of_triangle(corners, centre) - centre).norm() < ball.shape.radius) {
            for (const int node : nodes)
                EXPECT_NE(std::ranges::find(contact.near(), node), contact.near().end());
        }
    }
    // Where nodes are fast, it looks further.
    const auto before = contact.near().size();
    contact.look_around([&](int node) { return Vector3(mesh.points[node] + Vector3(0, 0, 5e-3)); });
    contact.look_around([&](int node) { return mesh.points[node]; });
    EXPECT_GT(contact.near().size(), before);
}

/// Masses without springs between them, on a surface that a ball has come into: sweeps end where p = eps g at each
/// point, nodes are given what points get, and a step that begins with those forces changes nothing.
TEST(BallContact, SweepsEndInThePenaltyAndStayThere) {
    const auto problem = tests::slid_block();
    const auto &mesh = problem.body->mesh;
    const auto facets = core::touched_facets(*problem.body, problem.load_case);
    const auto &ball = *problem.load_case.touching;
    constexpr double yields = 1e-3; // [m/N]
    core::BallContact contact(facets, 2, ball.shape.radius, 0.0);
    contact.set_way(ball.start + ball.press, ball.start + ball.press);
    std::vector<Vector3> x = mesh.points, given(x.size(), Vector3::Zero());
    const auto position = [&](int node) { return x[node]; };
    contact.look_around(position);
    const auto give = [&](int node, const Vector3 &force) {
        x[node] += yields * force;
        given[node] += force;
    };
    const auto sweep = [&] {
        contact.sweep(
            contact.part(0, 1), [&](int node) { return mesh.points[node]; }, position,
            [&](int) { return Eigen::Matrix3d(yields * Eigen::Matrix3d::Identity()); }, give);
    };
    for (int iteration = 0; iteration < 50; ++iteration)
        sweep();
    const Vector3 force = contact.force(), sum = std::accumulate(given.begin(), given.end(), Vector3(0, 0, 0));
    EXPECT_LT((force - sum).norm(), 1e-12 * sum.norm());
    Vector3 by_penalty = Vector3::Zero();
    for (const auto &facet : facets)
        for (const auto &point : core::facet_points(2)) {
            Vector3 d = -(ball.start + ball.press);
            for (std::size_t k = 0; k < 3; ++k)
                d += point.shape[k] * x[facet.nodes[k]];
            if (const double depth = ball.shape.radius - d.norm(); depth > 0.0)
                by_penalty += point.part * facet.area * facet.penalty(0.0) * depth * d.normalized();
        }
    EXPECT_NEAR(force.z(), by_penalty.z(), 1e-6 * force.norm());
    x = mesh.points;
    contact.begin_step(give);
    const auto there = x;
    sweep();
    for (std::size_t i = 0; i < x.size(); ++i)
        EXPECT_LT((x[i] - there[i]).norm(), 1e-9);
    contact.end_step(0.5);
    EXPECT_LT((contact.take_impulse() - 0.5 * force).norm(), 1e-6 * force.norm());
    EXPECT_EQ(contact.take_impulse(), Vector3::Zero());
}

} // namespace
} // namespace livermark
