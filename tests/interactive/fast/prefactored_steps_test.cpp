#include <Eigen/Geometry>
#include <array>
#include <gtest/gtest.h>

#include "interactive/method.hpp"
#include "tests/interactive/both_precisions.hpp"

namespace livermark {
namespace {

using core::Vector3;
using interactive::Field;
using interactive::Scene;
using tests::distance_over_motion;
using tests::Frames;
using tests::noise;
using tests::scenes_of_any_padding;
using tests::uneven_scene;

/// Steps with one factor in single precision, beside those in double precision.
struct PrefactoredStepsMethod : testing::TestWithParam<const char *> {
    const interactive::Method &method = interactive::find_method(GetParam());
};

TEST_P(PrefactoredStepsMethod, MoveAsInDoublePrecision) {
    for (const auto &frames : {Frames{1, 1}, Frames{1, 10}, Frames{5, 2}})
        for (const bool is_constrained : {true, false}) {
            const double distance = distance_over_motion(method, uneven_scene({5, 3, 3}, is_constrained, 5.0), frames);
            EXPECT_LT(distance, 1e-4) << frames.steps << " " << frames.iterations << " " << is_constrained;
            EXPECT_GT(distance, 0.0) << "both are the same code";
        }
}

TEST_P(PrefactoredStepsMethod, MoveAsInDoublePrecisionWithAnyPadding) {
    for (const auto &scene : scenes_of_any_padding())
        EXPECT_LT(distance_over_motion(method, scene, {2, 3}), 1e-4) << scene.node_mass.size();
}

/// One step from a shape at rest, in both precisions.
std::array<Field, 2> moves_from(const interactive::Method &method, const Scene &scene, const Field &x) {
    const auto move_of = [&](interactive::Simulation &simulation) {
        simulation.set_state(x, Field::Zero(3, x.cols()));
        simulation.step(2e-3, 1);
        return Field(simulation.positions() - x);
    };
    return {move_of(*method.prepare(scene)), move_of(*tests::prepare_slowly(method, scene))};
}

/// With supernodes of more than 16 columns. In steps of a whole frame these velocities turn hundreds of the small
/// tetrahedra inside out. No rotation is the nearest to a matrix where two of its singular values cancel, so there
/// a motion jumps: single precision is then about as far from double precision as that is from itself when the
/// motion begins 3 nm away. In a fifth of a frame few are inside out.
TEST_P(PrefactoredStepsMethod, SolveWithALargeFactorAsInDoublePrecision) {
    for (const bool is_constrained : {true, false}) {
        const auto scene = uneven_scene({14, 7, 7}, is_constrained, 5.0);
        const Field rest = interactive::rest_positions(scene);
        const auto [found, expected] = moves_from(method, scene, rest + noise(rest.cols(), 2e-4, 7));
        EXPECT_LT((found - expected).norm(), 1e-5 * expected.norm());
        EXPECT_LT(distance_over_motion(method, scene, {5, 2}), 1e-4) << is_constrained;
    }
}

TEST_P(PrefactoredStepsMethod, KeepTheDigitsOfSmallStrains) {
    const auto scene = uneven_scene({5, 3, 3}, false);
    const Field rest = interactive::rest_positions(scene);
    const auto [found, expected] =
        moves_from(method, scene, rest + noise(rest.cols(), 1e-7, 1).cast<float>().cast<double>());
    EXPECT_LT((found - expected).norm(), 1e-4 * expected.norm());
    EXPECT_GT(expected.norm(), 0.0);
}

TEST_P(PrefactoredStepsMethod, HardlyMoveWhereTheBodyIsTurned) {
    const auto scene = uneven_scene({5, 3, 3}, false);
    const Field rest = interactive::rest_positions(scene);
    for (const double angle : {0.5, 2.0, 3.1}) {
        const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, Vector3(1.0, -2.0, 0.5).normalized()).matrix();
        const double turned = moves_from(method, scene, turn * rest)[0].norm();
        const double stretched = moves_from(method, scene, 1.1 * rest)[0].norm();
        EXPECT_LT(turned, 1e-4 * stretched) << angle;
        EXPECT_GT(stretched, 0.0);
    }
}

TEST_P(PrefactoredStepsMethod, MoveAsInDoublePrecisionFromLargeStrains) {
    const auto scene = uneven_scene({5, 3, 3}, false);
    const Field rest = interactive::rest_positions(scene);
    const auto is_as_in_double = [&](const Field &x, double part) {
        const auto [found, expected] = moves_from(method, scene, x);
        EXPECT_LT((found - expected).norm(), part * expected.norm());
    };
    is_as_in_double(Vector3(1.8, 0.6, 1.1).asDiagonal() * rest, 1e-5);
    is_as_in_double(Vector3(0.3, 1.5, 1.2).asDiagonal() * rest, 1e-5);
    is_as_in_double(Vector3(1.3, 0.9, -0.5).asDiagonal() * rest, 1e-5); // inside out
    is_as_in_double(rest + noise(rest.cols(), 2e-3, 7), 1e-4);
}

TEST_P(PrefactoredStepsMethod, StayAtRestToTheLastBit) {
    const auto simulation = method.prepare(uneven_scene({3, 2, 1}, true));
    const Field rest = simulation->positions();
    for (int i = 0; i < 5; ++i)
        simulation->step(2e-3, 10);
    EXPECT_EQ(simulation->positions(), rest);
}

TEST_P(PrefactoredStepsMethod, PutConstrainedNodesExactlyWhereTheyAreToldToBe) {
    tests::expect_constrained_nodes_at_targets(method);
}

TEST_P(PrefactoredStepsMethod, ConserveMomentum) {
    tests::expect_momentum_to_stay(method, 5, 1e-4);
}

TEST_P(PrefactoredStepsMethod, AreTheSameOnAnyVectorsThatMultiplyAndAddAtOnce) {
    tests::expect_the_same_on_any_vectors(method, {2, 3}, 1e-4);
}

TEST_P(PrefactoredStepsMethod, FactoriseBeforeTheFirstStepWhereTheyAreToldTo) {
    const auto scene = uneven_scene({5, 3, 3}, true, 5.0);
    const auto prepared = method.prepare(scene), other = method.prepare(scene);
    const double without_factor = prepared->cost(3).bytes_per_element;
    prepared->prepare(2e-3);
    EXPECT_GT(prepared->cost(3).bytes_per_element, without_factor + 8.0);
    EXPECT_EQ(prepared->cost(3).element_passes, 3.0);
    for (auto *const simulation : {prepared.get(), other.get()}) {
        simulation->set_external_forces(noise(simulation->positions().cols(), 1e-2, 3));
        simulation->step(2e-3, 3);
    }
    EXPECT_EQ(prepared->positions(), other->positions());
    EXPECT_EQ(prepared->cost(3).bytes_per_element, other->cost(3).bytes_per_element);
}

INSTANTIATE_TEST_SUITE_P(All, PrefactoredStepsMethod, testing::Values("projective_dynamics", "fast_mass_spring"));

} // namespace
} // namespace livermark
