#include "msm/cutting/cut_parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "msm/kernels/fast_steps.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "tests/samples/moving_samples.hpp"
#include "tests/samples/springs_to_cut.hpp"

namespace livermark {
namespace {

using core::Vector3;

class CutParts : public tests::CutBox {
  protected:
    std::vector<int> next_cut(double x, double distance) { return take_near(body, x, distance); }
};

TEST_P(CutParts, HaveTheNumbersOfTheCutBodySetUpAnew) {
    parts.remove(next_cut(0.03, 0.018));
    parts.remove(next_cut(0.045, 0.02));
    ASSERT_GT(removed.size(), 60U);
    tests::expect_numbers_of_set_up(parts, GetParam(), body, removed);
}

template <class T> void expect_equal(const msm::SlicedBody<T> &is, const msm::SlicedBody<T> &should) {
    EXPECT_EQ(is.spring, should.spring);
    EXPECT_EQ(is.neighbour, should.neighbour);
    EXPECT_EQ(is.corner, should.corner);
    EXPECT_EQ(is.force_slot, should.force_slot);
    EXPECT_EQ(is.rest_volume, should.rest_volume);
    EXPECT_EQ(is.volume_share, should.volume_share);
    EXPECT_EQ(is.tetrahedron_stiffness, should.tetrahedron_stiffness);
    EXPECT_EQ(is.least_volume, should.least_volume);
    EXPECT_EQ(is.guard_stiffness, should.guard_stiffness);
    EXPECT_EQ(is.rest_gradient, should.rest_gradient);
    EXPECT_EQ(is.inner_modulus, should.inner_modulus);
    EXPECT_EQ(is.volume_modulus, should.volume_modulus);
    EXPECT_EQ(is.coupled_modulus, should.coupled_modulus);
    EXPECT_EQ(is.inverse_volume, should.inverse_volume);
    EXPECT_EQ(is.volume_stiffness, should.volume_stiffness);
    EXPECT_EQ(is.mean_start, should.mean_start);
    EXPECT_EQ(is.mean_node, should.mean_node);
    EXPECT_EQ(is.mean_gradient, should.mean_gradient);
    EXPECT_EQ(is.mean_volume, should.mean_volume);
    EXPECT_EQ(is.mean_weight, should.mean_weight);
    EXPECT_EQ(is.star_start, should.star_start);
    EXPECT_EQ(is.star_corner, should.star_corner);
    EXPECT_EQ(is.star_slot, should.star_slot);
    EXPECT_EQ(is.star_tetrahedron, should.star_tetrahedron);
    EXPECT_EQ(is.star_modulus, should.star_modulus);
    EXPECT_EQ(is.star_inverse_volume, should.star_inverse_volume);
    EXPECT_EQ(is.star_stiffness, should.star_stiffness);
    EXPECT_EQ(is.sum, should.sum);
    EXPECT_EQ(is.member, should.member);
    EXPECT_EQ(is.longest_star, should.longest_star);
}

TEST_P(CutParts, AreSlicedAsBySlicingAllAgain) {
    const auto &points = body.mesh.points;
    const auto check = [&]<class T>(T /*precision*/) {
        removed.clear();
        parts = msm::CutParts::prepare(body, elastic, GetParam().source(body)).value();
        msm::SlicedPlan plan;
        auto sliced = msm::sliced_body<T>(parts.parts(), points, &plan);
        for (const double x : {0.03, 0.05, 0.01}) {
            const auto &changes = parts.remove(next_cut(x, 0.02));
            ASSERT_FALSE(changes.nodes.empty());
            msm::update_sliced_body(parts.parts(), changes, plan, sliced);
            expect_equal(sliced, msm::sliced_body<T>(parts.parts(), points));
        }
    };
    check(float());
    check(double());
}

/// Steps that go on after a cut, and those of the cut body from the same state.
TEST_P(CutParts, MoveAsTheCutBodySetUpAnew) {
    msm::NodalConditions conditions;
    std::mt19937 random(11);
    conditions = tests::some_conditions(body.mesh.points.size(), random);
    for (const double beta : {0.0, 1e-5}) {
        removed.clear();
        parts = msm::CutParts::prepare(body, elastic, GetParam().source(body)).value();
        constexpr double step = 2e-5;
        const core::RayleighDamping damping{.alpha = 1.0, .beta = beta};
        auto steps = msm::FastSteps::prepare(elastic, body.mesh.points, conditions, damping, "symplectic_euler", step,
                                             {.precision = msm::ForcePrecision::double_precision, .may_be_cut = true});
        ASSERT_TRUE(steps);
        msm::State state = steps->state();
        for (int i = 0; i < static_cast<int>(body.mesh.points.size()); ++i)
            if (conditions.displacement[i].array().isNaN().all())
                msm::of_node(state.displacement, i) = tests::random_vector(random, 0.0004);
        steps->set_state(state);
        steps->take(20);
        for (const double x : {0.03, 0.05}) {
            const auto &changes = parts.remove(next_cut(x, 0.02));
            EXPECT_TRUE(steps->cut(parts.parts(), parts.node_mass(), changes));
        }
        const auto [rest, number] = tests::without(body, removed);
        msm::NodalConditions of_rest;
        const auto before = steps->state();
        msm::State start{Eigen::VectorXd(3 * rest.mesh.num_nodes()), Eigen::VectorXd(3 * rest.mesh.num_nodes())};
        for (std::size_t i = 0; i < number.size(); ++i)
            if (number[i] >= 0) {
                of_rest.displacement.push_back(conditions.displacement[i]);
                of_rest.force.push_back(conditions.force[i]);
                msm::of_node(start.displacement, number[i]) = msm::of_node(before.displacement, static_cast<int>(i));
                msm::of_node(start.velocity, number[i]) = msm::of_node(before.velocity, static_cast<int>(i));
            }
        auto anew =
            msm::FastSteps::prepare(GetParam().make(rest), rest.mesh.points, of_rest, damping, "symplectic_euler", step,
                                    {.precision = msm::ForcePrecision::double_precision});
        anew->set_state(start);
        steps->take(30);
        anew->take(30);
        const auto is = steps->state(), should = anew->state();
        double largest = 0.0, difference = 0.0;
        for (std::size_t i = 0; i < number.size(); ++i) {
            const Vector3 velocity = msm::of_node(is.velocity, static_cast<int>(i));
            if (number[i] < 0) {
                EXPECT_EQ(velocity, Vector3::Zero()) << i;
                EXPECT_EQ(Vector3(msm::of_node(is.displacement, static_cast<int>(i))),
                          Vector3(msm::of_node(before.displacement, static_cast<int>(i))))
                    << i;
                continue;
            }
            const Vector3 expected = msm::of_node(should.velocity, number[i]);
            largest = std::max(largest, expected.norm());
            difference = std::max(difference, (velocity - expected).norm());
        }
        EXPECT_GT(largest, 1e-3);
        EXPECT_LT(difference, 1e-9 * largest) << beta;
    }
}

INSTANTIATE_TEST_SUITE_P(AllSprings, CutParts, testing::ValuesIn(tests::all_springs_to_cut()),
                         tests::name_of_springs_to_cut);

} // namespace
} // namespace livermark
