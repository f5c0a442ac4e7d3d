#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "interactive/method.hpp"
#include "tests/interactive/both_precisions.hpp"

namespace livermark {
namespace {

using core::Vector3;
using interactive::Field;
using tests::distance_over_motion;
using tests::Frames;
using tests::noise;
using tests::uneven_scene;

/// Co-rotational elements in single precision, beside those in double precision.
struct CorotationalSteps : testing::Test {
    const interactive::Method &method = interactive::find_method("corotational_implicit");

    /// Of the velocities after a step from a shape at rest, between both precisions, over those of double precision.
    double distance_of_step_from(const interactive::Scene &scene, const Field &displacement, int iterations) const {
        const auto fast = method.prepare(scene), slow = tests::prepare_slowly(method, scene);
        for (const auto *simulation : {&fast, &slow}) {
            (*simulation)->set_state((*simulation)->positions() + displacement, Field::Zero(3, displacement.cols()));
            (*simulation)->step(1e-3, iterations);
        }
        EXPECT_GT(slow->velocities().norm(), 0.0);
        return (fast->velocities() - slow->velocities()).norm() / slow->velocities().norm();
    }
};

TEST_F(CorotationalSteps, MoveAsInDoublePrecision) {
    for (const auto &frames : {Frames{1, 5}, Frames{1, 25}, Frames{7, 1}, Frames{2, 200}})
        for (const bool is_constrained : {true, false}) {
            const double distance = distance_over_motion(method, uneven_scene({5, 3, 3}, is_constrained, 5.0), frames);
            EXPECT_LT(distance, 1e-4) << frames.steps << " " << frames.iterations << " " << is_constrained;
            EXPECT_GT(distance, 0.0) << "both are the same code";
        }
}

/// At Poisson's ratio 0.49 ten iterations in 1/120 s are so far from converged that they enlarge the last digit.
TEST_F(CorotationalSteps, MoveAsInDoublePrecisionWithAnyPadding) {
    for (const auto &scene : tests::scenes_of_any_padding())
        EXPECT_LT(distance_over_motion(method, scene, {7, 10}), 1e-5) << scene.node_mass.size();
}

TEST_F(CorotationalSteps, GiveTheForcesOfDoublePrecision) {
    const auto [single, in_double] = tests::dragged_in_both(method, uneven_scene({5, 3, 3}, true, 5.0), {1, 25});
    const Field forces = in_double->elastic_forces(), reactions = in_double->reactions();
    EXPECT_LT((single->elastic_forces() - forces).norm(), 2e-3 * forces.norm());
    EXPECT_LT((single->reactions() - reactions).norm(), 2e-3 * reactions.norm());
    EXPECT_GT(reactions.norm(), 0.01);
}

/// From one rotation to any other at once: by more than Newton's method finds, and where tetrahedra are inside out.
TEST_F(CorotationalSteps, FindRotationsThatAreFarAway) {
    for (const auto &scene : tests::scenes_of_any_padding()) {
        const Field rest = interactive::rest_positions(scene);
        const Field shape = noise(rest.cols(), 1e-3, 1).cast<float>().cast<double>();
        for (const double angle : {0.2, 1.0, 2.0, 3.1}) {
            const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, Vector3(1.0, -2.0, 0.5).normalized()).matrix();
            const Field there = (turn * (rest + shape) - rest).cast<float>().cast<double>();
            EXPECT_LT(distance_of_step_from(scene, there, 20), 2e-4) << rest.cols() << " " << angle;
        }
        Field mirrored = shape;
        mirrored.row(2) -= 2.0 * rest.row(2);
        mirrored.row(0) += 0.2 * rest.row(0); // so that one singular value is the least
        EXPECT_LT(distance_of_step_from(scene, mirrored.cast<float>().cast<double>(), 20), 1e-3) << rest.cols();
    }
}

TEST_F(CorotationalSteps, KeepTheDigitsOfForcesWhereStrainsAreSmall) {
    for (const auto &scene : tests::scenes_of_any_padding()) {
        const Field rest = interactive::rest_positions(scene);
        const Field tiny = noise(rest.cols(), 1e-8, 1).cast<float>().cast<double>();
        EXPECT_LT(distance_of_step_from(scene, tiny, 20), 2e-5) << rest.cols();
    }
}

TEST_F(CorotationalSteps, StayAtRestToTheLastBit) {
    const auto simulation = method.prepare(uneven_scene({3, 2, 1}, true));
    const Field rest = simulation->positions();
    for (int i = 0; i < 5; ++i)
        simulation->step(2e-3, 20);
    EXPECT_EQ(simulation->positions(), rest);
    EXPECT_EQ(simulation->velocities(), Field::Zero(3, rest.cols()));
}

TEST_F(CorotationalSteps, PutConstrainedNodesExactlyWhereTheyAreToldToBe) {
    tests::expect_constrained_nodes_at_targets(method);
}

TEST_F(CorotationalSteps, ConserveMomentum) {
    tests::expect_momentum_to_stay(method, 100, 1e-5);
}

TEST_F(CorotationalSteps, AreTheSameOnAnyVectorsThatMultiplyAndAddAtOnce) {
    tests::expect_the_same_on_any_vectors(method, {2, 10}, 1e-4);
}

} // namespace
} // namespace livermark
