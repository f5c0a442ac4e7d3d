#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <set>

#include "msm/cutting/cut_parts.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/springs/springs.hpp"
#include "tests/samples/cut_bodies.hpp"
#include "tests/samples/moving_samples.hpp"

namespace livermark {
namespace {

using core::Vector3;

msm::ElasticBody coupled_around_nodes(const core::Body &body) {
    return msm::coupled_springs_with_volume(body, msm::find_coupled_springs("nodal_neo_hookean"));
}

/// A soft bar with a hard lump from x = 0.04 to 0.08 m, held at its lower end, that is cut while it moves.
class ScaledCuts : public testing::Test {
  protected:
    ScaledCuts() {
        elastic = coupled_around_nodes(body);
        for (std::size_t i = 0; i < body.mesh.points.size(); ++i)
            if (body.mesh.points[i].x() < 0.001)
                conditions.displacement[i].setZero();
        scaling = msm::scale_masses(body, elastic, conditions);
        now = body;
        parts = msm::CutParts::prepare(body, elastic, std::nullopt);
    }

    static msm::FastStepOptions in_doubles(const msm::MassScaling &scaling) {
        return {.precision = msm::ForcePrecision::double_precision, .scaling = scaling, .may_be_cut = true};
    }

    /// Moving, its lump heavier.
    msm::FastSteps in_motion(double time_step) const {
        auto steps = msm::FastSteps::prepare(elastic, body.mesh.points, conditions, {}, "symplectic_euler", time_step,
                                             in_doubles(scaling))
                         .value();
        auto state = steps.state();
        std::mt19937 random(5);
        for (int i = 0; i < body.mesh.num_nodes(); ++i)
            if (std::isnan(conditions.displacement[i].x()))
                msm::node_part(state.displacement, i) = tests::random_vector(random, 1e-4);
        steps.set_state(state);
        steps.take(10);
        return steps;
    }

    bool cut(msm::FastSteps &steps, const std::vector<int> &tetrahedra) {
        removed.insert(tetrahedra.begin(), tetrahedra.end());
        const auto &changes = parts->remove(tetrahedra);
        return steps.cut(parts->parts(), parts->node_mass(), changes);
    }

    bool part(msm::FastSteps &steps, double x) {
        const auto &changes = parts->part(tests::part_by_blade(now, removed, {x, 0.0, 0.0}, Vector3::UnitX(), 0.015));
        EXPECT_GT(changes.parent_node.size(), 2U);
        for (const int parent : changes.parent_node) {
            conditions.displacement.push_back(Vector3(conditions.displacement[parent]));
            conditions.force.emplace_back(Vector3::Zero());
            conditions.constraint.push_back({-1, -1, -1});
        }
        return steps.part(parts->parts(), parts->node_mass(), changes);
    }

    /// The body that is left, set up anew.
    struct Anew {
        tests::Rest rest;
        msm::ElasticBody elastic;
        msm::NodalConditions conditions;
    };
    Anew anew() const {
        auto rest = tests::without(now, removed);
        Anew result{rest, coupled_around_nodes(rest.body), {}};
        for (std::size_t i = 0; i < rest.number.size(); ++i)
            if (rest.number[i] >= 0) {
                result.conditions.displacement.push_back(conditions.displacement[i]);
                result.conditions.force.push_back(conditions.force[i]);
                result.conditions.constraint.push_back(conditions.constraint[i]);
            }
        return result;
    }
    static msm::MassScaling renumbered(msm::MassScaling scaling, const std::vector<int> &number) {
        for (auto &part : scaling.parts)
            for (int &node : part.nodes)
                node = number[node];
        return scaling;
    }
    /// The scaling of what is left, in the numbers that nodes have before the cut.
    static msm::MassScaling scaling_of(const Anew &anew) {
        std::vector<int> before(anew.rest.body.mesh.points.size());
        for_all(anew, [&](int node, int now) { before[now] = node; });
        return renumbered(msm::scale_masses(anew.rest.body, anew.elastic, anew.conditions), before);
    }

    /// Goes on, beside the body that was set up anew in the same state.
    void expect_to_move_as(const Anew &anew, const msm::MassScaling &its_scaling, double time_step,
                           msm::FastSteps &steps) const {
        auto others = msm::FastSteps::prepare(anew.elastic, anew.rest.body.mesh.points, anew.conditions, {},
                                              "symplectic_euler", time_step, in_doubles(its_scaling))
                          .value();
        auto start = others.state();
        const auto before = steps.state();
        for_all(anew, [&](int node, int now) {
            msm::node_part(start.displacement, now) = msm::node_part(before.displacement, node);
            msm::node_part(start.velocity, now) = msm::node_part(before.velocity, node);
        });
        others.set_state(start);
        steps.take(30);
        others.take(30);
        const auto is = steps.state(), should = others.state();
        double largest = 0.0, difference = 0.0, change = 0.0;
        for_all(anew, [&](int node, int now) {
            const Vector3 expected = msm::node_part(should.velocity, now);
            largest = std::max(largest, expected.norm());
            difference = std::max(difference, (expected - msm::node_part(is.velocity, node)).norm());
            change = std::max(change, (expected - msm::node_part(start.velocity, now)).norm());
        });
        EXPECT_GT(change, 0.1 * largest);
        EXPECT_LT(difference, 1e-9 * largest);
    }
    template <class Visit> static void for_all(const Anew &anew, Visit visit) {
        for (std::size_t i = 0; i < anew.rest.number.size(); ++i)
            if (anew.rest.number[i] >= 0)
                visit(static_cast<int>(i), anew.rest.number[i]);
    }

    double highest(const Anew &anew, const msm::MassScaling &its_scaling) const {
        return msm::largest_angular_frequency(anew.elastic, anew.rest.body.mesh.points, anew.conditions, its_scaling,
                                              1e-6);
    }

    std::vector<int> through_lump() const { return tests::tetrahedra_near(body, {0.06, 0.02, 0.04}, 0.017); }

    core::Body body = tests::lumpy_bar({6, 2, 2}, 30.0);
    msm::ElasticBody elastic{{}, {}};
    msm::NodalConditions conditions = tests::free_conditions(body.mesh.points.size());
    msm::MassScaling scaling;
    std::optional<msm::CutParts> parts;
    core::Body now; ///< by the numbers that are kept
    std::set<int> removed;
};

/// By a cut, or by a blade that parts.
class ScaledCutsOfBothKinds : public ScaledCuts, public testing::WithParamInterface<bool> {};

TEST_F(ScaledCuts, ThatTakeAStiffPartAwayMoveAsTheCutBodySetUpAnewWithoutScaling) {
    const double step = 1e-4;
    auto steps = in_motion(step);
    std::vector<int> all; // that have a node of the lump
    for (int t = 0; t < body.mesh.num_tetrahedra(); ++t)
        if (std::ranges::any_of(body.mesh.tetrahedra[t], [&](int node) {
                return std::ranges::binary_search(scaling.parts.front().nodes, node);
            }))
            all.push_back(t);
    EXPECT_TRUE(cut(steps, all));
    expect_to_move_as(anew(), {}, step, steps);
}

TEST_P(ScaledCutsOfBothKinds, BesideTheStiffPartMoveAsWhatIsLeftSetUpAnewWithTheSameScaling) {
    ASSERT_EQ(scaling.parts.size(), 1U);
    const double step = 1e-4;
    auto steps = in_motion(step);
    const auto soft = tests::tetrahedra_near(body, {0.12, 0.02, 0.04}, 0.02);
    ASSERT_GT(soft.size(), 3U);
    EXPECT_TRUE(GetParam() ? part(steps, 0.1) : cut(steps, soft));
    const auto rest = anew();
    expect_to_move_as(rest, renumbered(scaling, rest.rest.number), step, steps);
}

TEST_P(ScaledCutsOfBothKinds, ThroughTheStiffPartMoveUnscaledAndThenWithTheScalingOfWhatIsLeft) {
    auto steps = in_motion(1e-4);
    ASSERT_GT(through_lump().size(), 3U);
    EXPECT_FALSE(GetParam() ? part(steps, 0.06) : cut(steps, through_lump()));
    const auto rest = anew();
    const double unscaled = highest(rest, {});
    steps.set_time_step(1.0 / unscaled);
    expect_to_move_as(rest, {}, 1.0 / unscaled, steps);

    const auto again = scaling_of(rest);
    ASSERT_FALSE(again.parts.empty());
    const auto renumbered_again = renumbered(again, rest.rest.number);
    const double scaled = highest(rest, renumbered_again);
    EXPECT_LT(scaled, 0.5 * unscaled);
    EXPECT_TRUE(steps.set_scaling(again));
    steps.set_time_step(1.0 / scaled);
    expect_to_move_as(rest, renumbered_again, 1.0 / scaled, steps);
}

INSTANTIATE_TEST_SUITE_P(CutAndPart, ScaledCutsOfBothKinds, testing::Bool());

TEST_F(ScaledCuts, AreStableUpToTheCriticalStepOfTheCutBodySetUpAnewAndNotBeyond) {
    auto steps = in_motion(1e-4);
    cut(steps, through_lump());
    const auto rest = anew();
    const auto again = scaling_of(rest);
    auto cut_in_motion = steps.state();
    for (auto *field : {&cut_in_motion.displacement, &cut_in_motion.velocity})
        *field *= 0.01; // so small that frequencies are those at rest
    const double size = cut_in_motion.displacement.norm();
    for (const bool is_scaled : {false, true}) {
        const msm::MassScaling its_scaling = is_scaled ? again : msm::MassScaling{};
        const double critical = 2.0 / highest(rest, renumbered(its_scaling, rest.rest.number));
        ASSERT_TRUE(steps.set_scaling(its_scaling));
        for (const double part : {0.97, 1.03}) {
            steps.set_state(cut_in_motion);
            steps.set_time_step(part * critical);
            steps.take(400);
            const double now = steps.state().displacement.norm();
            EXPECT_EQ(now < 100.0 * size, part < 1.0) << is_scaled << " " << part << " " << now / size;
        }
    }
}

TEST_F(ScaledCuts, AreRefusedScalingThatTheIntegratorDoesNotKnow) {
    auto steps = msm::FastSteps::prepare(elastic, body.mesh.points, conditions, {}, "heun", 1e-5, in_doubles({}));
    ASSERT_TRUE(steps);
    EXPECT_FALSE(steps->set_scaling(scaling));
}

} // namespace
} // namespace livermark
