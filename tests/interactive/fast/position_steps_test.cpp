#include <gtest/gtest.h>

#include "interactive/method.hpp"
#include "tests/interactive/both_precisions.hpp"

namespace livermark {
namespace {

using interactive::Field;
using tests::distance_over_motion;
using tests::dragged_in_both;
using tests::Frames;
using tests::scenes_of_any_padding;
using tests::uneven_scene;

/// Steps of position-based methods in single precision, beside those in double precision.
struct PositionStepsMethod : testing::TestWithParam<const char *> {
    const interactive::Method &method = interactive::find_method(GetParam());
};

/// In steps of a whole frame xpbd_neo_hookean is no method to compare with: in double precision it makes a tenth of a
/// micrometre out of the last digit in two steps, and a centimetre in five.
TEST_P(PositionStepsMethod, MoveAsInDoublePrecision) {
    for (const auto &frames : {Frames{7, 1}, Frames{7, 10}})
        for (const bool is_constrained : {true, false}) {
            const double distance = distance_over_motion(method, uneven_scene({5, 3, 3}, is_constrained, 5.0), frames);
            EXPECT_LT(distance, 8e-4) << frames.iterations << " " << is_constrained;
            EXPECT_GT(distance, 0.0) << "both are the same code";
        }
}

TEST_P(PositionStepsMethod, MoveAsInDoublePrecisionWithAnyPadding) {
    for (const auto &scene : scenes_of_any_padding())
        EXPECT_LT(distance_over_motion(method, scene, {7, 1}), 8e-4) << scene.node_mass.size();
}

TEST_P(PositionStepsMethod, GiveTheForcesOfDoublePrecision) {
    const auto [single, in_double] = dragged_in_both(method, uneven_scene({5, 3, 3}, true, 5.0), {7, 1});
    const Field forces = in_double->elastic_forces(), reactions = in_double->reactions();
    EXPECT_LT((single->elastic_forces() - forces).norm(), 2e-3 * forces.norm());
    EXPECT_LT((single->reactions() - reactions).norm(), 2e-3 * reactions.norm());
    EXPECT_GT(reactions.norm(), 0.01);
}

TEST_P(PositionStepsMethod, StayAtRestWhereNothingMovesThem) {
    const auto simulation = method.prepare(uneven_scene({3, 2, 1}, true));
    const Field rest = simulation->positions();
    for (int i = 0; i < 5; ++i)
        simulation->step(2e-3, 10);
    EXPECT_LT((simulation->positions() - rest).cwiseAbs().maxCoeff(), 1e-7); // of 60 mm
    EXPECT_EQ(simulation->positions().cols(), rest.cols());
}

TEST_P(PositionStepsMethod, PutConstrainedNodesExactlyWhereTheyAreToldToBe) {
    tests::expect_constrained_nodes_at_targets(method);
}

TEST_P(PositionStepsMethod, ConserveMomentum) {
    tests::expect_momentum_to_stay(method, 5, 1e-5);
}

TEST_P(PositionStepsMethod, AreTheSameOnAnyVectorsThatMultiplyAndAddAtOnce) {
    tests::expect_the_same_on_any_vectors(method, {7, 1}, 8e-4);
}

INSTANTIATE_TEST_SUITE_P(All, PositionStepsMethod, testing::Values("xpbd_springs", "xpbd_neo_hookean"));

} // namespace
} // namespace livermark
