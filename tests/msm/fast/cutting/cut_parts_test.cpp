#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <set>
#include <tuple>

#include "msm/cutting/cut_parts.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "msm/springs/springs.hpp"
#include "tests/samples/cut_bodies.hpp"
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

template <class T> auto all_of(const msm::SlicedBody<T> &b) {
    return std::tie(b.spring, b.neighbour, b.corner, b.force_slot, b.rest_volume, b.volume_share,
                    b.tetrahedron_stiffness, b.least_volume, b.guard_stiffness, b.rest_gradient, b.inner_modulus,
                    b.volume_modulus, b.coupled_modulus, b.inverse_volume, b.volume_stiffness, b.mean_start,
                    b.mean_node, b.mean_gradient, b.mean_volume, b.mean_weight, b.edge_start, b.edge_member,
                    b.edge_modulus, b.inverse_edge_volume, b.fan_edge, b.sum, b.member);
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
            const auto anew = msm::sliced_body<T>(parts.parts(), points);
            EXPECT_TRUE(all_of(sliced) == all_of(anew)) << x;
        }
    };
    check(float());
    check(double());
}

struct Motion {
    std::string integrator = "symplectic_euler";
    double beta = 0.0;
    msm::ForcePrecision precision = msm::ForcePrecision::double_precision;
    int num_threads = 1;
    double tolerance = 1e-9;
};

/// Springs that move while they are cut.
class MovingCutBox : public tests::CutBox {
  protected:
    static constexpr double step = 2e-5;
    core::Body now = body; ///< by the numbers that are kept
    msm::NodalConditions conditions;

    const msm::PartingChanges &part(double x, double y_of_normal, double least_z) {
        return parts.part(tests::part_by_blade(now, removed, {x, 0.03, 0.0}, Vector3(1.0, y_of_normal, 0.0), least_z));
    }
    std::vector<int> near(double x, double distance) { return take_near(now, x, distance); }

    /// The whole body in motion, its nodes somewhere else by a little.
    msm::FastSteps whole_in_motion(const Motion &motion) {
        now = body;
        removed.clear();
        parts = msm::CutParts::prepare(body, elastic, GetParam().source(body)).value();
        std::mt19937 random(11);
        conditions = tests::some_conditions(body.mesh.points.size(), random);
        auto steps = msm::FastSteps::prepare(
                         elastic, body.mesh.points, conditions, {.alpha = 1.0, .beta = motion.beta}, motion.integrator,
                         step, {.precision = motion.precision, .num_threads = motion.num_threads, .may_be_cut = true})
                         .value();
        auto state = steps.state();
        for (int i = 0; i < body.mesh.num_nodes(); ++i)
            if (conditions.displacement[i].array().isNaN().all())
                msm::node_part(state.displacement, i) = tests::random_vector(random, 0.0004);
        steps.set_state(state);
        steps.take(20);
        return steps;
    }

    /// Steps that go on, and those of what is left set up anew from the same state.
    void expect_the_motion_of_a_set_up(const Motion &motion, msm::FastSteps &steps) const {
        const auto [rest, number] = tests::without(now, removed);
        msm::NodalConditions left;
        const auto before = steps.state();
        msm::State start{Eigen::VectorXd(3 * rest.mesh.num_nodes()), Eigen::VectorXd(3 * rest.mesh.num_nodes())};
        for (std::size_t i = 0; i < number.size(); ++i)
            if (number[i] >= 0) {
                left.displacement.push_back(conditions.displacement[i]);
                left.force.push_back(conditions.force[i]);
                msm::node_part(start.displacement, number[i]) =
                    msm::node_part(before.displacement, static_cast<int>(i));
                msm::node_part(start.velocity, number[i]) = msm::node_part(before.velocity, static_cast<int>(i));
            }
        auto anew =
            msm::FastSteps::prepare(GetParam().make(rest), rest.mesh.points, left, {.alpha = 1.0, .beta = motion.beta},
                                    motion.integrator, step, {.precision = motion.precision});
        anew->set_state(start);
        steps.take(30);
        anew->take(30);
        const auto is = steps.state(), should = anew->state();
        double largest = 0.0, difference = 0.0;
        for (std::size_t i = 0; i < number.size(); ++i) {
            const Vector3 velocity = msm::node_part(is.velocity, static_cast<int>(i));
            if (number[i] < 0) {
                EXPECT_EQ(velocity, Vector3::Zero()) << i;
                EXPECT_EQ(Vector3(msm::node_part(is.displacement, static_cast<int>(i))),
                          Vector3(msm::node_part(before.displacement, static_cast<int>(i))))
                    << i;
                continue;
            }
            const Vector3 expected = msm::node_part(should.velocity, number[i]);
            largest = std::max(largest, expected.norm());
            difference = std::max(difference, (velocity - expected).norm());
        }
        EXPECT_GT(largest, 1e-3);
        EXPECT_LT(difference, motion.tolerance * largest);
    }
};

TEST_P(MovingCutBox, GoesOnAfterCutsAsTheCutBodySetUpAnew) {
    for (const double beta : {0.0, 1e-5}) {
        SCOPED_TRACE(beta);
        auto steps = whole_in_motion({.beta = beta});
        for (const double x : {0.03, 0.05})
            EXPECT_TRUE(steps.cut(parts.parts(), parts.node_mass(), parts.remove(near(x, 0.02))));
        expect_the_motion_of_a_set_up({.beta = beta}, steps);
    }
}

TEST_P(MovingCutBox, HasTheNumbersOfThePartedBodySetUpAnew) {
    const auto num_before = parts.node_mass().size();
    part(0.03, 0.2, 0.02);
    ASSERT_GT(parts.node_mass().size(), num_before + 6);
    tests::expect_numbers_of_set_up(parts, GetParam(), now, removed);
    parts.remove(near(0.03, 0.016));
    ASSERT_GT(removed.size(), 20U);
    tests::expect_numbers_of_set_up(parts, GetParam(), now, removed);
    part(0.034, 0.2, 0.01);
    part(0.05, -0.3, 0.02);
    tests::expect_numbers_of_set_up(parts, GetParam(), now, removed);
    parts.remove(near(0.05, 0.016));
    tests::expect_numbers_of_set_up(parts, GetParam(), now, removed);
}

/// The conditions of a node for those in its place, its load shared by mass.
msm::NodalConditions as_parted(const msm::NodalConditions &before, const std::vector<int> &origin,
                               const std::vector<double> &mass) {
    std::vector<double> mass_there(before.force.size(), 0.0);
    for (std::size_t i = 0; i < origin.size(); ++i)
        mass_there[origin[i]] += mass[i];
    msm::NodalConditions conditions;
    for (std::size_t i = 0; i < origin.size(); ++i) {
        conditions.displacement.push_back(before.displacement[origin[i]]);
        conditions.force.push_back(before.force[origin[i]] * mass[i] / mass_there[origin[i]]);
        conditions.constraint.push_back({-1, -1, -1});
    }
    return conditions;
}

Vector3 momentum(const msm::State &state, const std::vector<double> &mass) {
    Vector3 sum = Vector3::Zero();
    for (std::size_t i = 0; i < mass.size(); ++i)
        sum += mass[i] * msm::node_part(state.velocity, static_cast<int>(i));
    return sum;
}

/// New nodes are where their parents are and as fast, so momentum stays.
TEST_P(MovingCutBox, GoesOnAfterEachPartingAsThePartedBodySetUpAnew) {
    using enum msm::ForcePrecision;
    for (const auto &motion : {Motion{}, Motion{.beta = 1e-5}, Motion{.precision = single_precision, .tolerance = 1e-4},
                               Motion{.num_threads = 3}, Motion{.integrator = "velocity_verlet"},
                               Motion{.integrator = "runge_kutta_4"}, Motion{.integrator = "runge_kutta_chebyshev"}}) {
        SCOPED_TRACE(motion.integrator);
        auto steps = whole_in_motion(motion);
        bool has_constrained = false;
        const auto go_on = [&](double x, double y_of_normal, double least_z) {
            const auto mass_before = parts.node_mass();
            const auto &changes = part(x, y_of_normal, least_z);
            const auto before = steps.state();
            EXPECT_TRUE(steps.part(parts.parts(), parts.node_mass(), changes));
            const auto after = steps.state();
            ASSERT_EQ(after.velocity.size(), 3 * std::ssize(parts.node_mass()));
            std::vector<int> origin(mass_before.size());
            std::iota(origin.begin(), origin.end(), 0);
            origin.insert(origin.end(), changes.parent_node.begin(), changes.parent_node.end());
            for (const int parent : changes.parent_node)
                has_constrained = has_constrained || !conditions.displacement[parent].array().isNaN().all();
            for (int i = 0; i < static_cast<int>(origin.size()); ++i) {
                EXPECT_EQ(Vector3(msm::node_part(after.velocity, i)),
                          Vector3(msm::node_part(before.velocity, origin[i])));
                EXPECT_EQ(Vector3(msm::node_part(after.displacement, i)),
                          Vector3(msm::node_part(before.displacement, origin[i])));
            }
            const Vector3 was = momentum(before, mass_before), is = momentum(after, parts.node_mass());
            EXPECT_LT((is - was).norm(), 1e-13 * was.norm());
            conditions = as_parted(conditions, origin, parts.node_mass());
            expect_the_motion_of_a_set_up(motion, steps);
        };
        go_on(0.03, 0.2, 0.02);
        EXPECT_TRUE(steps.cut(parts.parts(), parts.node_mass(), parts.remove(near(0.03, 0.016))));
        go_on(0.034, 0.2, 0.01);
        go_on(0.05, -0.3, 0.02);
        EXPECT_TRUE(steps.cut(parts.parts(), parts.node_mass(), parts.remove(near(0.05, 0.016))));
        expect_the_motion_of_a_set_up(motion, steps);
        EXPECT_TRUE(has_constrained);
    }
}

INSTANTIATE_TEST_SUITE_P(AllSprings, CutParts, testing::ValuesIn(tests::all_springs_to_cut()),
                         tests::name_of_springs_to_cut);
INSTANTIATE_TEST_SUITE_P(AllSprings, MovingCutBox, testing::ValuesIn(tests::all_springs_to_cut()),
                         tests::name_of_springs_to_cut);

/// A box of which tetrahedra go and are parted at once, and its own numbers of what is left.
struct CutBox {
    core::Body kept = tests::crooked_box({0.07, 0.06, 0.05}, {6, 5, 4}); ///< by the numbers that are kept
    std::set<int> removed;
    tests::Rest rest = tests::without(kept, removed);
    std::vector<int> left = numbers_of_left(); ///< the number of each tetrahedron of the rest

    std::vector<int> numbers_of_left() const {
        std::vector<int> numbers;
        for (int t = 0; t < kept.mesh.num_tetrahedra(); ++t)
            if (!removed.contains(t))
                numbers.push_back(t);
        return numbers;
    }
    /// @return parents of tetrahedra in the rest before
    std::vector<int> cut(double x, double distance, msm::Parting &parting) {
        for (const int t : tests::tetrahedra_near(kept, {x, 0.03, 0.05}, distance))
            removed.insert(t);
        parting = tests::part_by_blade(kept, removed, {x, 0.0, 0.0}, Vector3(1.0, 0.2, 0.0), 0.01);
        std::vector<int> parents;
        for (std::size_t t = 0; t < left.size(); ++t)
            if (!removed.contains(left[t]))
                parents.push_back(static_cast<int>(t));
        rest = tests::without(kept, removed);
        left = numbers_of_left();
        return parents;
    }
};

TEST(KeptNumbers, AreThoseOfTheBodyBeforeAllCuts) {
    CutBox box;
    msm::KeptNumbers numbers(box.kept.mesh);
    std::set<int> gone;
    for (const double x : {0.03, 0.045}) {
        msm::Parting expected;
        const auto parents = box.cut(x, 0.014, expected);
        const auto cut = numbers.follow(box.rest.body.mesh, parents);
        gone.insert(cut.removed.begin(), cut.removed.end());
        EXPECT_EQ(gone, box.removed);
        ASSERT_GT(expected.parent_node.size(), 3U);
        EXPECT_EQ(cut.parting.parent_node, expected.parent_node);
        EXPECT_EQ(cut.parting.tetrahedra, expected.tetrahedra);
        EXPECT_EQ(cut.parting.nodes, expected.nodes);
        EXPECT_EQ(numbers.num_nodes(), box.kept.mesh.num_nodes());
        for (int i = 0; i < box.kept.mesh.num_nodes(); ++i)
            if (const int now = box.rest.number[i]; now >= 0) {
                EXPECT_EQ(numbers.nodes()[now], i);
            }
    }
}

TEST(KeptNumbers, PartNothingWhereNothingIsParted) {
    CutBox box;
    msm::KeptNumbers numbers(box.kept.mesh);
    box.removed = {0, 7, 100};
    const auto cut = numbers.follow(tests::without(box.kept, box.removed).body.mesh, box.numbers_of_left());
    EXPECT_EQ(cut.removed, (std::vector<int>{0, 7, 100}));
    EXPECT_TRUE(cut.parting.tetrahedra.empty());
    EXPECT_TRUE(cut.parting.parent_node.empty());
}

msm::NodalConditions held_below(const core::Body &body, double x) {
    auto conditions = tests::free_conditions(body.mesh.points.size());
    for (std::size_t i = 0; i < body.mesh.points.size(); ++i)
        if (body.mesh.points[i].x() < x)
            conditions.displacement[i].setZero();
    return conditions;
}

TEST(FrequencyAround, TellsThatOfTheCutBodyWithTheFrequencyBefore) {
    const auto body = tests::crooked_box({0.2, 0.04, 0.04}, {20, 4, 4});
    const auto &law = *std::ranges::find(msm::all_spring_laws(), "van_gelder", &msm::SpringLaw::name);
    const std::vector<std::function<msm::ElasticBody(const core::Body &)>> all_springs{
        [](const core::Body &of) {
            return msm::coupled_springs_with_volume(of, msm::find_coupled_springs("nodal_neo_hookean"));
        },
        [&](const core::Body &of) {
            return msm::springs_with_volume(of, msm::springs_beside_volume(of, law),
                                            msm::find_volume_term("nodal_volume"))
                .body;
        }};
    constexpr double tolerance = 1e-6;
    for (const auto &make : all_springs)
        for (const double x : {0.06, 0.11, 0.16}) {
            const auto near = tests::tetrahedra_near(body, {x, 0.02, 0.04}, 0.014);
            std::vector<char> is_removed(body.mesh.tetrahedra.size(), 0);
            std::set<int> nodes;
            for (const int t : near) {
                is_removed[t] = 1;
                nodes.insert(body.mesh.tetrahedra[t].begin(), body.mesh.tetrahedra[t].end());
            }
            const double around = msm::frequency_around(
                body, is_removed, std::vector<int>(nodes.begin(), nodes.end()),
                [&](const msm::PartOfBody &part) { return make(part.body); }, held_below(body, 0.005), tolerance);
            const double before =
                msm::largest_angular_frequency(make(body), body.mesh.points, held_below(body, 0.005), {}, tolerance);
            const auto rest = tests::without(body, {near.begin(), near.end()}).body;
            const double after =
                msm::largest_angular_frequency(make(rest), rest.mesh.points, held_below(rest, 0.005), {}, tolerance);
            EXPECT_LT(around, after * (1.0 + 1e-4)) << x;
            EXPECT_GT(std::max(around, before), 0.99 * after) << x;
        }
}

TEST(FrequencyAround, IsNothingWhereNothingIsLeftToMove) {
    const auto body = tests::crooked_box({0.02, 0.02, 0.02}, {1, 1, 1});
    const std::vector<char> all(body.mesh.tetrahedra.size(), 1);
    const auto make = [](const msm::PartOfBody &part) {
        return msm::coupled_springs_with_volume(part.body, msm::find_coupled_springs("nodal_springs"));
    };
    EXPECT_EQ(msm::frequency_around(body, all, std::vector<int>{0, 1}, make, held_below(body, 0.0), 1e-6), 0.0);
}

} // namespace
} // namespace livermark
