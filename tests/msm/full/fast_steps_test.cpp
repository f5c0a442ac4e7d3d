#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "msm/dynamics/stepper.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/springs/springs.hpp"
#include "tests/oracles/linear_elements.hpp"
#include "tests/samples/moving_samples.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;
using msm::FastSteps;
using msm::State;
using tests::by_the_kernel;
using tests::by_the_oracle;
using tests::error;
using tests::EveryVectorUnit;
using tests::Sample;
using tests::shaken;
using tests::tetrahedra;
using tests::tolerance;

/// Springs between nodes at random places, each with its neighbours in number and with some others:
/// one in so many.
Sample random_springs(int num_nodes, unsigned int one_in = 50) {
    std::mt19937 random(num_nodes);
    Sample sample;
    core::SpringNetwork springs;
    for (int i = 0; i < num_nodes; ++i) {
        sample.positions.emplace_back(tests::random_vector(random, 0.1));
        springs.node_mass.push_back(tests::random_value(random, 0.001, 0.003));
        for (int j = 0; j < i; ++j)
            if (i - j < 3 || random() % one_in == 0) {
                springs.edges.push_back({j, i});
                springs.rest_length.push_back((sample.positions[i] - sample.positions[j]).norm());
                springs.stiffness.push_back(tests::random_value(random, 10.0, 100.0));
            }
    }
    sample.body = springs;
    sample.conditions = tests::some_conditions(sample.positions.size(), random);
    return sample;
}

TEST_P(EveryVectorUnit, MovesAnyNumberOfNodesAsTheOracleDoes) {
    for (const int num_nodes : {0, 1, 2, 3, 5, 7, 8, 9, 15, 16, 17, 31, 32, 33, 63, 64, 65, 300})
        for (const auto &damping : {core::RayleighDamping{0.0, 0.0}, core::RayleighDamping{3.0, 0.002}})
            for (const auto precision : tests::both_precisions) {
                SCOPED_TRACE(num_nodes);
                const auto sample = random_springs(num_nodes);
                const auto expected = by_the_oracle(sample, damping, "symplectic_euler", 3);
                const auto found = by_the_kernel(sample, damping, "symplectic_euler", 3, {.precision = precision});
                if (num_nodes > 0) {
                    EXPECT_LT(error(found, expected, sample), tolerance(precision));
                }
            }
}

TEST_P(EveryVectorUnit, MovesAnyNumberOfTetrahedraAsTheOracleDoes) {
    for (const int count : {1, 2, 15, 16, 17, 33, 108})
        for (const auto *term : {"", "nodal_volume", "tetrahedral_volume"}) {
            SCOPED_TRACE(testing::Message() << count << " " << term);
            tests::expect_what_the_oracle_does(tetrahedra(count, term));
        }
}

TEST_P(EveryVectorUnit, KnowsEveryExplicitIntegrator) {
    const auto sample = tetrahedra(108, "nodal_volume");
    for (const auto &integrator : msm::known_integrators()) {
        if (!integrator.is_explicit)
            continue;
        for (const auto precision : tests::both_precisions) {
            SCOPED_TRACE(integrator.name);
            const core::RayleighDamping damping{3.0, 0.002};
            const auto expected = by_the_oracle(sample, damping, integrator.name, 4);
            const auto found = by_the_kernel(sample, damping, integrator.name, 4, {.precision = precision});
            EXPECT_LT(error(found, expected, sample), tolerance(precision));
        }
    }
}

TEST_P(EveryVectorUnit, TakesAnyNumberOfStages) {
    const auto sample = tetrahedra(108, "nodal_volume");
    const core::RayleighDamping damping{3.0, 0.002};
    const auto &usual = msm::find_integrator("runge_kutta_chebyshev");
    for (const int num_stages : {2, 5, 12})
        for (const auto precision : tests::both_precisions) {
            SCOPED_TRACE(num_stages);
            const auto integrator = usual.with_forces_per_step(num_stages);
            EXPECT_EQ(integrator.forces_per_step, num_stages);
            const auto expected = by_the_oracle(sample, damping, integrator, 4);
            const auto found =
                by_the_kernel(sample, damping, integrator.name, 4, {.precision = precision, .num_stages = num_stages});
            EXPECT_LT(error(found, expected, sample), tolerance(precision));
        }
}

TEST_P(EveryVectorUnit, GivesTheSameForAnyNumberOfThreads) {
    tests::expect_the_same_for_any_number_of_threads(tetrahedra(108, "nodal_volume"));
}

/// A thread moves nodes that others do not see while these are still at work: all of a chain but its seams. Where
/// springs go everywhere there are none, and in few slices some threads have nothing to do.
TEST_P(EveryVectorUnit, GivesTheSameForAnyNumberOfThreadsThatShareSprings) {
    constexpr int never = 1 << 20;
    for (const auto &sample : {random_springs(1000, never), random_springs(300), random_springs(20)})
        tests::expect_the_same_for_any_number_of_threads(sample);
}

INSTANTIATE_TEST_SUITE_P(FastSteps, EveryVectorUnit, testing::ValuesIn(hwy::SupportedAndGeneratedTargets()),
                         tests::name_of_unit);

TEST(FastSteps, GoOnWhereTheyStopped) {
    const auto sample = tetrahedra(108, "nodal_volume");
    const core::RayleighDamping damping{3.0, 0.002};
    auto steps = FastSteps::prepare(sample.body, sample.positions, sample.conditions, damping, "velocity_verlet",
                                    tests::sample_step);
    ASSERT_TRUE(steps.has_value());
    steps->set_state(shaken(sample));
    for (int s = 0; s < 5; ++s)
        steps->take(1);
    EXPECT_EQ(steps->state().velocity, by_the_kernel(sample, damping, "velocity_verlet", 5, {}).velocity);
}

/// A constrained node that is moved by itself is where a state that is set would put it, and nothing else moves.
TEST(FastSteps, MoveConstrainedNodesOneByOne) {
    const auto sample = tetrahedra(108, "nodal_volume");
    for (const auto precision : tests::both_precisions) {
        const auto prepare = [&] {
            auto steps = FastSteps::prepare(sample.body, sample.positions, sample.conditions, {}, "symplectic_euler",
                                            tests::sample_step, {.precision = precision});
            steps->set_state(shaken(sample));
            steps->take(3);
            steps->set_state(steps->state()); // what rounding has left is shared out as in a state that is set
            return *steps;
        };
        auto one_by_one = prepare(), at_once = prepare();
        auto state = at_once.state();
        const Vector3 way{0.001, -0.002, 0.003};
        for (std::size_t i = 0; i < sample.positions.size(); ++i) {
            one_by_one.set_displacement(static_cast<int>(i), way);
            for (Eigen::Index c = 0; c < 3; ++c)
                if (!std::isnan(sample.conditions.displacement[i][c]))
                    state.displacement[3 * static_cast<Eigen::Index>(i) + c] = way[c];
        }
        at_once.set_state(state);
        EXPECT_EQ(one_by_one.state().displacement, at_once.state().displacement);
        one_by_one.take(3);
        at_once.take(3);
        EXPECT_EQ(one_by_one.state().velocity, at_once.state().velocity);
    }
}

/// A spring is kept at both ends with 12 bytes each at most, and slices are filled up with few that are none.
TEST(FastSteps, NeedLittleMemoryForASpring) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {12, 12, 12});
    const auto body = tests::make_body(mesh, {1060.0, 5e3, 0.25});
    const auto springs = msm::spring_network(*body, msm::all_spring_laws().front());
    const auto steps = FastSteps::prepare(springs, mesh.points, tests::free_conditions(mesh.points.size()), {},
                                          "symplectic_euler", tests::sample_step);
    constexpr double node_bytes = 2 * 24 + 12 + 2 * 16; // position and velocity, inverse mass, two rows
    const double all_node_bytes = node_bytes * (static_cast<double>(mesh.points.size()) + 32.0);
    EXPECT_LT((static_cast<double>(steps->working_set()) - all_node_bytes) / static_cast<double>(springs.edges.size()),
              30.0);
}

/// Nothing is constrained or loaded.
Sample free_springs(const core::SpringNetwork &springs, const std::vector<Vector3> &positions) {
    return {springs, positions, tests::free_conditions(positions.size())};
}

State moved_on(const Sample &sample, const State &start, int num_steps) {
    auto steps = FastSteps::prepare(sample.body, sample.positions, sample.conditions, {}, "symplectic_euler",
                                    tests::sample_step);
    EXPECT_TRUE(steps.has_value());
    steps->set_state(start);
    steps->take(num_steps);
    return steps->state();
}

/// Two nodes that have no spring to each other are moved in one lane, and may be at one place.
TEST(FastSteps, MoveNodesThatAreAtOnePlace) {
    core::SpringNetwork springs;
    std::vector<Vector3> positions{Vector3::Zero()};
    springs.node_mass.assign(6, 0.002);
    for (int i = 1; i < 6; ++i) {
        positions.emplace_back(0.01, 0.02, 0.02);
        springs.edges.push_back({0, i});
        springs.rest_length.push_back(0.031);
        springs.stiffness.push_back(50.0);
    }
    const State still{Eigen::VectorXd::Zero(18), Eigen::VectorXd::Zero(18)};
    const auto state = moved_on(free_springs(springs, positions), still, 20);
    const double acceleration = 50.0 * 0.001 / 0.002;
    const double way = 0.5 * acceleration * std::pow(20 * tests::sample_step, 2.0);
    for (int i = 1; i < 6; ++i) {
        const Vector3 displacement = state.displacement.segment<3>(3 * i);
        EXPECT_EQ(displacement, state.displacement.segment<3>(3));
        EXPECT_NEAR(displacement.norm(), way, 0.1 * way);
    }
}

TEST(FastSteps, HaveNoDisplacementAtRest) {
    const auto sample = random_springs(301);
    for (const auto precision : tests::both_precisions) {
        const auto steps = FastSteps::prepare(sample.body, sample.positions, sample.conditions, {}, "symplectic_euler",
                                              tests::sample_step, {.precision = precision});
        ASSERT_TRUE(steps.has_value());
        EXPECT_EQ(steps->state().displacement, Eigen::VectorXd::Zero(3 * 301));
    }
}

/// With an odd number of nodes a lane has one only, beside a neighbour in the middle of the body.
TEST(FastSteps, MoveANodeThatIsAlone) {
    core::SpringNetwork springs;
    springs.node_mass.assign(3, 0.002);
    springs.edges = {{0, 1}, {1, 2}};
    springs.rest_length.assign(2, 0.11);
    springs.stiffness.assign(2, 50.0);
    const auto sample = free_springs(springs, {Vector3(-0.1, 0, 0), Vector3::Zero(), Vector3(0.1, 0, 0)});
    const auto state = moved_on(sample, {Eigen::VectorXd::Zero(9), Eigen::VectorXd::Zero(9)}, 10);
    EXPECT_GT(state.displacement[6], 1e-5);
    EXPECT_NEAR(state.displacement[0], -state.displacement[6], 1e-5 * state.displacement[6]);
    EXPECT_NEAR(state.displacement[3], 0.0, 1e-5 * state.displacement[6]);
}

/// Steps add up to twice the digits of the forces: single precision alone would lose of many small ones.
TEST(FastSteps, LoseNothingOfSmallSteps) {
    constexpr double speed = 1e-4; // 1e-8 m in a step, where the last digit of 0.1 m is 7e-9 m
    constexpr int num_steps = 20000;
    core::SpringNetwork springs;
    springs.node_mass = {1.0, 1.0};
    springs.edges = {{0, 1}};
    springs.rest_length = {0.2};
    springs.stiffness = {1e-6};
    const auto sample = free_springs(springs, {Vector3(-0.1, 0.0, 0.0), Vector3(0.1, 0.0, 0.0)});
    const auto state = moved_on(sample, {Eigen::VectorXd::Zero(6), Eigen::VectorXd::Constant(6, speed)}, num_steps);
    const double way = speed * num_steps * tests::sample_step;
    EXPECT_LT((state.displacement - Eigen::VectorXd::Constant(6, way)).lpNorm<Eigen::Infinity>(), 1e-6 * way);
}

TEST(FastSteps, AreNotThereForImplicitIntegrators) {
    const auto sample = random_springs(5);
    EXPECT_FALSE(
        FastSteps::prepare(sample.body, sample.positions, sample.conditions, {}, "implicit_euler", tests::sample_step)
            .has_value());
}

constexpr auto all_counts = {1, 2, 15, 16, 17, 33, 108};

/// Springs with an energy that the kernels know.
constexpr std::array all_with_energy{"nodal_neo_hookean", "nodal_neo_hookean_f", "edge_neo_hookean",
                                     "edge_neo_hookean_f"};

/// The body pressed or pulled along x and sheared, and every node somewhere else by a little: no tetrahedron is inside
/// out, as the energy does not allow it.
msm::State deformed(const Sample &sample, double stretch) {
    std::mt19937 random(7);
    auto state = tests::shaken(sample);
    for (std::size_t i = 0; i < sample.positions.size(); ++i) {
        const auto &x = sample.positions[i];
        const core::Vector3 moved((stretch - 1.0) * x.x() + 0.2 * x.y(), 0.1 * x.z(), 0.0);
        const core::Vector3 displacement = moved + tests::random_vector(random, 0.0005);
        for (int c = 0; c < 3; ++c)
            state.displacement[static_cast<Eigen::Index>(3 * i) + c] = displacement[c];
    }
    return state;
}

/// Largest difference of the velocities after some steps from there, as a part of their largest change.
double error_from(const msm::State &start, const Sample &sample, const core::RayleighDamping &damping,
                  const std::string &integrator, msm::ForcePrecision precision) {
    auto expected = start;
    const auto equation = msm::elastic_motion(sample.body, sample.positions, sample.conditions, damping);
    const auto step = msm::find_integrator(integrator).prepare(equation, tests::sample_step);
    auto steps = msm::FastSteps::prepare(sample.body, sample.positions, sample.conditions, damping, integrator,
                                         tests::sample_step, {.precision = precision})
                     .value();
    steps.set_state(start);
    steps.take(3);
    for (int s = 0; s < 3; ++s)
        step(expected);
    return (steps.state().velocity - expected.velocity).lpNorm<Eigen::Infinity>() /
           (expected.velocity - start.velocity).lpNorm<Eigen::Infinity>();
}

/// Pressed, at about its size, and pulled.
void expect_with_energy_what_the_oracle_does(const Sample &sample) {
    for (const double stretch : {0.6, 1.0, 1.5})
        for (const auto &damping : {core::RayleighDamping{0.0, 0.0}, core::RayleighDamping{3.0, 0.002}})
            for (const auto *integrator : {"symplectic_euler", "runge_kutta_4"})
                for (const auto precision : tests::both_precisions)
                    EXPECT_LT(error_from(deformed(sample, stretch), sample, damping, integrator, precision),
                              tests::tolerance(precision))
                        << stretch << " " << damping.beta << " " << integrator;
}

class CoupledSprings : public tests::EveryVectorUnit {};

TEST_P(CoupledSprings, AroundNodesMoveAsTheOracleDoes) {
    for (const int count : all_counts)
        for (const auto &[soft_ratio, hard_ratio] :
             {std::pair(0.25, 0.25), std::pair(0.45, 0.45), std::pair(0.25, 0.4)}) {
            SCOPED_TRACE(testing::Message() << count << " " << soft_ratio << " " << hard_ratio);
            tests::expect_what_the_oracle_does(tests::coupled("nodal_springs", count, soft_ratio, hard_ratio));
        }
}

TEST_P(CoupledSprings, WithAnEnergyMoveAsTheOracleDoesWherePressedAndPulled) {
    for (const auto *springs : all_with_energy)
        for (const int count : all_counts)
            for (const auto &[soft_ratio, hard_ratio] :
                 {std::pair(0.25, 0.25), std::pair(0.1, 0.45), std::pair(0.45, 0.45)}) {
                SCOPED_TRACE(testing::Message() << springs << " " << count << " " << soft_ratio << " " << hard_ratio);
                expect_with_energy_what_the_oracle_does(tests::coupled(springs, count, soft_ratio, hard_ratio));
            }
}

TEST_P(CoupledSprings, WithAnEnergyMoveAsTheOracleDoesBesideTheGuard) {
    const auto body = tests::two_materials(108, 0.1, 0.45);
    for (const auto *springs : all_with_energy) {
        SCOPED_TRACE(springs);
        auto sample = tests::coupled(springs, 108, 0.1, 0.45);
        sample.body.terms.push_back(msm::inversion_guard(body));
        expect_with_energy_what_the_oracle_does(sample);
    }
}

TEST_P(CoupledSprings, GiveTheSameForAnyNumberOfThreads) {
    tests::expect_the_same_for_any_number_of_threads(tests::coupled("nodal_springs", 108, 0.4, 0.45));
    for (const auto *springs : all_with_energy)
        tests::expect_the_same_for_any_number_of_threads(tests::coupled(springs, 108, 0.25, 0.45));
}

INSTANTIATE_TEST_SUITE_P(FastSteps, CoupledSprings, testing::ValuesIn(hwy::SupportedAndGeneratedTargets()),
                         tests::name_of_unit);

bool are_there(const core::Body &body, std::vector<std::shared_ptr<const msm::ElasticTerm>> terms) {
    auto sample = tests::loose(body);
    sample.body.terms = std::move(terms);
    return msm::FastSteps::prepare(sample.body, sample.positions, sample.conditions, {}, "symplectic_euler",
                                   tests::sample_step)
        .has_value();
}

TEST(FastSteps, AreNotThereForSpringsOfBothKindsAndBesideVolumesOfTheOtherKind) {
    const auto body = tests::two_materials(108, 0.25, 0.45);
    const auto edges = msm::coupled_springs(body, msm::find_coupled_springs("edge_neo_hookean")),
               nodes = msm::coupled_springs(body, msm::find_coupled_springs("nodal_neo_hookean")),
               elements = tests::linear_elements(body);
    for (const auto &terms : {std::vector{edges, nodes}, {nodes, edges}, {nodes, elements}, {elements}})
        EXPECT_FALSE(are_there(body, terms));
    for (const auto *springs : all_with_energy)
        for (const auto *name : {"nodal_volume", "tetrahedral_volume"})
            EXPECT_FALSE(are_there(body, {msm::coupled_springs(body, msm::find_coupled_springs(springs)),
                                          msm::volume_beside_springs(body, msm::find_volume_term(name))}))
                << springs << " " << name;
}

TEST(FastSteps, AreThereForTheCoupledSpringsThatSayThatTheyKnow) {
    const auto body = tests::two_materials(108, 0.25, 0.45);
    for (const auto &springs : msm::all_coupled_springs())
        EXPECT_EQ(are_there(body, msm::coupled_springs_with_volume(body, springs).terms), msm::are_in_kernels(springs))
            << springs.name;
}

} // namespace
} // namespace livermark
