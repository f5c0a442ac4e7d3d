#include <gtest/gtest.h>

#include <random>
#include <set>

#include "msm/cutting/cut_parts.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "tests/samples/moving_samples.hpp"
#include "tests/samples/springs_to_cut.hpp"

namespace livermark {
namespace {

using core::Vector3;

/// A box that is parted, loses tetrahedra, and is parted again.
class PartedParts : public tests::CutBox {
  protected:
    core::Body now = body; ///< by the numbers that are kept

    const msm::PartingChanges &part(double x, double y_of_normal, double least_z) {
        return parts.part(tests::part_by_blade(now, removed, {x, 0.03, 0.0}, Vector3(1.0, y_of_normal, 0.0), least_z));
    }
    std::vector<int> near(double x, double distance) { return take_near(now, x, distance); }
};

TEST_P(PartedParts, HaveTheNumbersOfThePartedBodySetUpAnew) {
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
    std::vector<double> of_origin(before.force.size(), 0.0);
    for (std::size_t i = 0; i < origin.size(); ++i)
        of_origin[origin[i]] += mass[i];
    msm::NodalConditions conditions;
    for (std::size_t i = 0; i < origin.size(); ++i) {
        conditions.displacement.push_back(before.displacement[origin[i]]);
        conditions.force.push_back(before.force[origin[i]] * mass[i] / of_origin[origin[i]]);
        conditions.constraint.push_back({-1, -1, -1});
    }
    return conditions;
}

Vector3 momentum(const msm::State &state, const std::vector<double> &mass) {
    Vector3 sum = Vector3::Zero();
    for (std::size_t i = 0; i < mass.size(); ++i)
        sum += mass[i] * msm::of_node(state.velocity, static_cast<int>(i));
    return sum;
}

/// Steps that go on after each parting, and those of the parted body from the same state.
struct Motion {
    std::string integrator = "symplectic_euler";
    double beta = 0.0;
    msm::ForcePrecision precision = msm::ForcePrecision::double_precision;
    int num_threads = 1;
    double tolerance = 1e-9;
};

class MovingPartedParts : public PartedParts {
  protected:
    void expect_to_move_as_set_up_anew(const Motion &motion) {
        std::mt19937 random(11);
        const auto whole = tests::some_conditions(body.mesh.points.size(), random);
        auto conditions = whole;
        constexpr double step = 2e-5;
        const core::RayleighDamping damping{.alpha = 1.0, .beta = motion.beta};
        auto steps = msm::FastSteps::prepare(
            elastic, body.mesh.points, conditions, damping, motion.integrator, step,
            {.precision = motion.precision, .num_threads = motion.num_threads, .may_be_cut = true});
        ASSERT_TRUE(steps);
        auto state = steps->state();
        for (int i = 0; i < body.mesh.num_nodes(); ++i)
            if (conditions.displacement[i].array().isNaN().all())
                msm::of_node(state.displacement, i) = tests::random_vector(random, 0.0004);
        steps->set_state(state);
        steps->take(20);
        bool has_constrained = false;
        const auto go_on = [&](const msm::PartingChanges &changes, const std::vector<double> &mass_before) {
            const auto before = steps->state();
            EXPECT_TRUE(steps->part(parts.parts(), parts.node_mass(), changes));
            const auto after = steps->state();
            ASSERT_EQ(after.velocity.size(), 3 * std::ssize(parts.node_mass()));
            std::vector<int> origin(mass_before.size());
            for (std::size_t i = 0; i < origin.size(); ++i)
                origin[i] = static_cast<int>(i);
            origin.insert(origin.end(), changes.parent_node.begin(), changes.parent_node.end());
            for (const int parent : changes.parent_node)
                has_constrained = has_constrained || !conditions.displacement[parent].array().isNaN().all();
            for (int i = 0; i < static_cast<int>(origin.size()); ++i) {
                EXPECT_EQ(Vector3(msm::of_node(after.velocity, i)), Vector3(msm::of_node(before.velocity, origin[i])));
                EXPECT_EQ(Vector3(msm::of_node(after.displacement, i)),
                          Vector3(msm::of_node(before.displacement, origin[i])));
            }
            const Vector3 was = momentum(before, mass_before), is = momentum(after, parts.node_mass());
            EXPECT_LT((is - was).norm(), 1e-13 * was.norm());
            conditions = as_parted(conditions, origin, parts.node_mass());
            expect_the_same_motion(conditions, motion, damping, step, *steps);
        };
        auto mass = parts.node_mass();
        go_on(part(0.03, 0.2, 0.02), mass);
        EXPECT_TRUE(steps->cut(parts.parts(), parts.node_mass(), parts.remove(near(0.03, 0.016))));
        mass = parts.node_mass();
        go_on(part(0.034, 0.2, 0.01), mass);
        mass = parts.node_mass();
        go_on(part(0.05, -0.3, 0.02), mass);
        EXPECT_TRUE(steps->cut(parts.parts(), parts.node_mass(), parts.remove(near(0.05, 0.016))));
        expect_the_same_motion(conditions, motion, damping, step, *steps);
        EXPECT_TRUE(has_constrained);
    }

  private:
    void expect_the_same_motion(const msm::NodalConditions &conditions, const Motion &motion,
                                const core::RayleighDamping &damping, double step, msm::FastSteps &steps) const {
        const auto [rest, number] = tests::without(now, removed);
        msm::NodalConditions of_rest;
        const auto before = steps.state();
        msm::State start{Eigen::VectorXd(3 * rest.mesh.num_nodes()), Eigen::VectorXd(3 * rest.mesh.num_nodes())};
        for (std::size_t i = 0; i < number.size(); ++i)
            if (number[i] >= 0) {
                of_rest.displacement.push_back(conditions.displacement[i]);
                of_rest.force.push_back(conditions.force[i]);
                msm::of_node(start.displacement, number[i]) = msm::of_node(before.displacement, static_cast<int>(i));
                msm::of_node(start.velocity, number[i]) = msm::of_node(before.velocity, static_cast<int>(i));
            }
        auto anew = msm::FastSteps::prepare(GetParam().make(rest), rest.mesh.points, of_rest, damping,
                                            motion.integrator, step, {.precision = motion.precision});
        anew->set_state(start);
        steps.take(30);
        anew->take(30);
        const auto is = steps.state(), should = anew->state();
        double largest = 0.0, difference = 0.0;
        for (std::size_t i = 0; i < number.size(); ++i) {
            const Vector3 velocity = msm::of_node(is.velocity, static_cast<int>(i));
            if (number[i] < 0) {
                EXPECT_EQ(velocity, Vector3::Zero()) << i;
                continue;
            }
            const Vector3 expected = msm::of_node(should.velocity, number[i]);
            largest = std::max(largest, expected.norm());
            difference = std::max(difference, (velocity - expected).norm());
        }
        EXPECT_GT(largest, 1e-3);
        EXPECT_LT(difference, motion.tolerance * largest);
    }
};

TEST_P(MovingPartedParts, MoveAsThePartedBodySetUpAnew) {
    expect_to_move_as_set_up_anew({});
}

TEST_P(MovingPartedParts, MoveAsThePartedBodySetUpAnewWhereStiffnessDamps) {
    expect_to_move_as_set_up_anew({.beta = 1e-5});
}

TEST_P(MovingPartedParts, MoveAsThePartedBodySetUpAnewInSinglePrecision) {
    expect_to_move_as_set_up_anew({.precision = msm::ForcePrecision::single_precision, .tolerance = 1e-4});
}

TEST_P(MovingPartedParts, MoveAsThePartedBodySetUpAnewOnThreads) {
    expect_to_move_as_set_up_anew({.num_threads = 3});
}

TEST_P(MovingPartedParts, MoveAsThePartedBodySetUpAnewByOtherIntegrators) {
    for (const char *integrator : {"velocity_verlet", "runge_kutta_4", "runge_kutta_chebyshev"}) {
        now = body;
        removed.clear();
        parts = msm::CutParts::prepare(body, elastic, GetParam().source(body)).value();
        expect_to_move_as_set_up_anew({.integrator = integrator});
    }
}

INSTANTIATE_TEST_SUITE_P(AllSprings, PartedParts, testing::ValuesIn(tests::all_springs_to_cut()),
                         tests::name_of_springs_to_cut);
INSTANTIATE_TEST_SUITE_P(AllSprings, MovingPartedParts, testing::ValuesIn(tests::all_springs_to_cut()),
                         tests::name_of_springs_to_cut);

} // namespace
} // namespace livermark
