#include "results/records/result.hpp"

#include <gtest/gtest.h>
#include <stdexcept>

#include "core/error_norms.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::results {
namespace {

/// An exact solution, and what has an error of a given share of it.
struct Sequence {
    core::TetraMesh mesh = tests::box_mesh({0.2, 0.1, 0.1}, {2, 1, 1});

    core::Solution with_error(double share) const {
        core::Solution solution;
        for (const auto &point : mesh.points)
            solution.displacement.emplace_back((1.0 - share) * 0.01 * (point + core::Vector3(0.01, 0.02, 0.03)));
        solution.reaction = {(1.0 - share) * core::Vector3(1.0, 2.0, 3.0)};
        solution.strain_energy = 1.0 - share;
        return solution;
    }
    ReferenceUncertainty estimate(double coarse_error, double refined_error) const {
        return estimate_uncertainty(mesh, {}, with_error(coarse_error), "coarse", with_error(refined_error), "refined");
    }
};

/// Errors that halve with the mesh size are estimated exactly.
TEST(ReferenceUncertainty, IsTheErrorOfASequenceOfFirstOrder) {
    const Sequence sequence;
    const auto found = sequence.estimate(0.04, 0.02);
    EXPECT_EQ(found.reference, "refined");
    EXPECT_EQ(found.refined, "refined");
    EXPECT_EQ(found.order, 1.0);
    // All are relative to the refined solution, which is 2 % too small itself.
    const auto truth = core::compare(sequence.mesh, {}, sequence.with_error(0.0), sequence.with_error(0.02), "refined");
    EXPECT_NEAR(found.relative_l2, truth.relative_l2, 1e-12);
    EXPECT_NEAR(found.energy_error, truth.energy_error, 1e-12);
    EXPECT_NEAR(found.reaction_error, truth.reaction_error, 1e-12);
    EXPECT_NEAR(found.refinement_difference, 0.02 / 0.98, 1e-12);
}

TEST(ReferenceUncertainty, LeavesTheReferenceOnTheMeshWhereThatIsGoodEnough) {
    const Sequence sequence;
    const auto found = sequence.estimate(0.008, 0.004);
    EXPECT_EQ(found.reference, "coarse");
    EXPECT_NEAR(found.relative_l2, 0.008 / 0.996, 1e-12);
    EXPECT_NEAR(found.refinement_difference, 0.004 / 0.996, 1e-12);
    EXPECT_EQ(sequence.estimate(0.0102, 0.0051).reference, "refined");
}

TEST(ReferenceUncertainty, IsTooLargeRatherThanTooSmallWhereTheOrderIsHigher) {
    const auto found = Sequence().estimate(0.08, 0.01);
    EXPECT_GT(found.relative_l2, 0.01);
}

/// Motions that are some part too small.
core::History too_small(double share) {
    core::History history;
    history.time = {0.0, 0.1, 0.2};
    for (const double amplitude : {1.0, 0.5, -0.7})
        history.displacement.emplace_back((1.0 - share) * amplitude, 0.0, 0.0);
    return history;
}

TEST(MotionUncertainty, OfTheFinerMotionIsWhatItObservedOrAsMuchAsBothDiffer) {
    auto refined = too_small(0.01);
    const auto assumed = estimate_motion_uncertainty(too_small(0.04), "coarse", refined, "refined");
    EXPECT_EQ(assumed.reference, "refined");
    EXPECT_EQ(assumed.refined, "refined");
    EXPECT_EQ(assumed.order, 1.0);
    EXPECT_NEAR(assumed.difference, 0.03 / 0.99, 1e-12);
    EXPECT_EQ(assumed.relative_l2, assumed.difference);
    refined.observed_error = core::ObservedMotionError{2.0, 0.03, 0.01};
    const auto observed = estimate_motion_uncertainty(too_small(0.04), "coarse", refined, "refined");
    EXPECT_EQ(observed.order, 2.0);
    EXPECT_EQ(observed.relative_l2, 0.01);
}

/// Newmark's steps are of second order: in a quarter of the length a sixteenth is left.
TEST(MotionUncertainty, HasThePartOfTheSteps) {
    auto coarse = too_small(0.04), refined = too_small(0.01);
    EXPECT_FALSE(uncertainty_of_steps(coarse, "coarse"));
    coarse.time_step = 0.004;
    refined.time_step = 0.001;
    coarse.observed_error = core::ObservedMotionError{2.0, 0.008, 0.008};
    refined.observed_error = core::ObservedMotionError{1.0, 0.03, 0.01};
    EXPECT_NEAR(estimate_motion_uncertainty(coarse, "coarse", refined, "refined").relative_l2, 0.01 + 0.0005, 1e-15);
    refined.time_step = 0.004;
    EXPECT_NEAR(estimate_motion_uncertainty(coarse, "coarse", refined, "refined").relative_l2, 0.01 + 0.008, 1e-15);
    const auto alone = uncertainty_of_steps(coarse, "coarse").value();
    EXPECT_TRUE(alone.is_of_steps_alone());
    EXPECT_EQ(alone.reference, "coarse");
    EXPECT_EQ(alone.relative_l2, 0.008);
    EXPECT_FALSE(estimate_motion_uncertainty(coarse, "coarse", refined, "refined").is_of_steps_alone());
}

TEST(MotionUncertainty, LeavesTheReferenceOnTheMeshWhereThatIsGoodEnough) {
    auto refined = too_small(0.001);
    refined.observed_error = core::ObservedMotionError{1.0, 0.002, 0.001};
    const auto found = estimate_motion_uncertainty(too_small(0.005), "coarse", refined, "refined");
    EXPECT_EQ(found.reference, "coarse");
    EXPECT_NEAR(found.relative_l2, 0.005, 1e-5);
    EXPECT_EQ(estimate_motion_uncertainty(too_small(0.012), "coarse", refined, "refined").reference, "refined");
}

TEST(ReferenceUncertainty, HasNoSign) {
    const auto found = Sequence().estimate(-0.04, -0.02);
    EXPECT_GT(found.energy_error, 0.0);
    EXPECT_GT(found.relative_l2, 0.0);
}

TEST(ReferenceUncertainty, RefusesARefinedSolutionThatIsNone) {
    const Sequence sequence;
    auto refined = sequence.with_error(0.0);
    refined.status = core::SolutionStatus::not_converged;
    EXPECT_THROW(estimate_uncertainty(sequence.mesh, {}, sequence.with_error(0.1), "coarse", refined, "refined"),
                 std::invalid_argument);
}

} // namespace
} // namespace livermark::results
