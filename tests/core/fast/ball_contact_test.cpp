#include <cmath>
#include <gtest/gtest.h>
#include <random>

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

TEST(BallPush, PutsPointsOutOfTheBallAndLeavesOthersWhereTheyAre) {
    RandomPoints points;
    for (const double friction : {0.0, 0.3, 10.0})
        for (int k = 0; k < 200; ++k) {
            const core::BallStep ball{Vector3::Zero(), points.near({0, 0, 0}, 0.1), 1.0, friction};
            const auto start = points.near({0, 0, 1}, 0.2), now = points.near({0, 0, 1}, 0.2);
            const auto push = core::ball_push(ball, start, now);
            const bool is_inside = (now - ball.to).norm() < 1.0;
            EXPECT_EQ(push == Vector3::Zero(), !is_inside);
            EXPECT_GE((now + push - ball.to).norm(), 1.0 - 1e-12);
        }
}

/// It never pulls, and friction is within its cone and against the way along the ball.
TEST(BallPush, KeepsToTheConeOfFriction) {
    RandomPoints points;
    int num_sticking = 0, num_slipping = 0;
    for (const double friction : {0.0, 0.3, 2.0})
        for (int k = 0; k < 300; ++k) {
            const core::BallStep ball{Vector3::Zero(), points.near({0, 0, 0}, 0.05), 1.0, friction};
            const auto start = points.near({0, 0, 1}, 0.1), now = points.near({0, 0, 0.95}, 0.1);
            const auto pushed = k % 2 == 0 ? Vector3(Vector3::Zero()) : points.near({0, 0, 0}, 0.1);
            const auto push = core::ball_push(ball, start, now, pushed);
            const Vector3 normal = (now - ball.to).normalized();
            const double inwards = push.dot(normal);
            const Vector3 along = push - inwards * normal;
            EXPECT_GE(inwards, 0.0);
            EXPECT_LE(along.norm(), friction * inwards + 1e-12);
            if (inwards == 0.0)
                continue;
            const Vector3 way = now + push - pushed - start - ball.to;
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

/// What iterations have pushed too much they take back.
TEST(BallPush, TakesBackWhatWasTooMuch) {
    const core::BallStep ball{Vector3::Zero(), Vector3::Zero(), 1.0, 0.0};
    const Vector3 start(0, 0, 1.0), pushed(0, 0, 0.2);
    EXPECT_NEAR(core::ball_push(ball, start, {0, 0, 1.05}, pushed).z(), 0.15, 1e-15);
    EXPECT_EQ(core::ball_push(ball, start, {0, 0, 1.3}, pushed), Vector3::Zero());
    EXPECT_NEAR(core::ball_push(ball, start, {0, 0, 0.9}, pushed).z(), 0.3, 1e-15);
}

/// Iterated until it stays: the conditions of contact hold, with the stiffness in between.
TEST(RestUnderBall, IsWhereForcesBalanceOutsideTheBallAndWithinTheCone) {
    RandomPoints points;
    int num_touched = 0, num_slipping = 0;
    for (const double friction : {0.0, 0.3})
        for (int k = 0; k < 100; ++k) {
            const core::BallStep ball{Vector3::Zero(), points.near({0, 0, 0}, 0.02), 1.0, friction};
            const auto start = Vector3(points.near({0, 0, 1}, 0.1).normalized());
            const auto minimum = points.near({0, 0, 0.97}, 0.1);
            Eigen::Matrix3d root;
            root << points.near({1, 0, 0}, 0.3), points.near({0, 2, 0}, 0.3), points.near({0, 0, 1}, 0.3);
            const Eigen::Matrix3d stiffness = root * root.transpose();
            auto node = core::NodeUnderBall{start, Vector3::Zero()};
            for (int iteration = 0; iteration < 200; ++iteration)
                node = core::rest_under_ball(ball, start, node.position, minimum, stiffness);
            const Vector3 out = node.position - ball.to;
            EXPECT_LT((stiffness * (minimum - node.position) + node.force).norm(), 1e-9);
            EXPECT_GE(out.norm(), 1.0 - 1e-12);
            if (node.force.isZero(0.0)) {
                EXPECT_GE((minimum - ball.to).norm(), 1.0);
                continue;
            }
            ++num_touched;
            const double inwards = node.force.dot(out.normalized());
            const double along = (node.force - inwards * out.normalized()).norm();
            EXPECT_GT(inwards, 0.0);
            EXPECT_LE(along, friction * inwards + 1e-6);
            num_slipping += friction > 0.0 && along > 0.999 * friction * inwards ? 1 : 0;
            if (friction == 0.0) {
                EXPECT_NEAR(out.norm(), 1.0, 1e-6);
            }
        }
    EXPECT_GT(num_touched, 50);
    EXPECT_GT(num_slipping, 10);
}

TEST(BallContact, GoesWhereTheToolGoes) {
    const auto problem = tests::slid_block();
    const auto &ball = *problem.load_case.touching;
    const auto &motion = *problem.load_case.tool;
    EXPECT_EQ(core::ball_centre(ball, motion, 0.0), ball.start);
    EXPECT_LT((core::ball_centre(ball, motion, 0.11) - ball.start - ball.press).norm(), 1e-15);
    EXPECT_LT((core::ball_centre(ball, motion, 0.3) - ball.start - ball.press - motion.slide).norm(), 1e-15);
    core::BallContact contact({}, 1.0, 0.2);
    contact.set_way({0, 0, 0}, {0, 0, 3});
    EXPECT_LT((contact.part(1, 3).from - Vector3(0, 0, 1)).norm(), 1e-15);
    EXPECT_LT((contact.part(1, 3).to - Vector3(0, 0, 2)).norm(), 1e-15);
    EXPECT_EQ(contact.part(2, 3).to, Vector3(0, 0, 3));
}

TEST(BallContact, SeesAllNodesThatItMayMeetAndNoHeldOnes) {
    const auto problem = tests::slid_block();
    const auto &mesh = problem.body->mesh;
    const auto nodes = core::touchable_nodes(mesh, problem.load_case);
    ASSERT_FALSE(nodes.empty());
    for (const int node : nodes)
        EXPECT_GT(mesh.points[node].z(), 0.0);
    core::BallContact contact(nodes, 0.02, 0.0);
    const auto &ball = *problem.load_case.touching;
    contact.set_way(ball.start, ball.start + ball.press);
    contact.look_around([&](int node) { return mesh.points[node]; });
    EXPECT_LT(contact.near().size(), nodes.size());
    for (const int node : nodes) {
        const bool is_met = (mesh.points[node] - ball.start - ball.press).norm() < ball.radius;
        if (is_met) {
            EXPECT_NE(std::ranges::find(contact.near(), node), contact.near().end());
        }
    }
    // Where nodes are fast, it looks further.
    const auto before = contact.near().size();
    contact.look_around([&](int node) { return Vector3(mesh.points[node] + Vector3(0, 0, 5e-3)); });
    contact.look_around([&](int node) { return mesh.points[node]; });
    EXPECT_GT(contact.near().size(), before);
}

} // namespace
} // namespace livermark
