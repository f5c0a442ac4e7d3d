#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <random>

#include "msm/dynamics/stepper.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/springs/spring_network.hpp"
#include "tests/oracles/linear_elements.hpp"
#include "tests/samples/moving_samples.hpp"

namespace livermark {
namespace {

using tests::Sample;

constexpr auto all_counts = {1, 2, 15, 16, 17, 33, 108};

/// Springs with an energy that the kernels know.
constexpr std::array all_with_energy{"nodal_neo_hookean", "nodal_neo_hookean_f", "edge_neo_hookean",
                                     "edge_neo_hookean_f"};

/// Tetrahedra with coupled springs, and with the volume around nodes where they have another Poisson's ratio.
Sample coupled(const char *springs, int num_tetrahedra, double soft_ratio, double hard_ratio) {
    const auto body = tests::two_materials(num_tetrahedra, soft_ratio, hard_ratio);
    auto sample = tests::loose(body);
    sample.body.terms = msm::coupled_springs_with_volume(body, msm::find_coupled_springs(springs)).terms;
    return sample;
}

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
            tests::expect_what_the_oracle_does(coupled("nodal_springs", count, soft_ratio, hard_ratio));
        }
}

TEST_P(CoupledSprings, WithAnEnergyMoveAsTheOracleDoesWherePressedAndPulled) {
    for (const auto *springs : all_with_energy)
        for (const int count : all_counts)
            for (const auto &[soft_ratio, hard_ratio] :
                 {std::pair(0.25, 0.25), std::pair(0.1, 0.45), std::pair(0.45, 0.45)}) {
                SCOPED_TRACE(testing::Message() << springs << " " << count << " " << soft_ratio << " " << hard_ratio);
                expect_with_energy_what_the_oracle_does(coupled(springs, count, soft_ratio, hard_ratio));
            }
}

TEST_P(CoupledSprings, WithAnEnergyMoveAsTheOracleDoesBesideTheGuard) {
    const auto body = tests::two_materials(108, 0.1, 0.45);
    for (const auto *springs : all_with_energy) {
        SCOPED_TRACE(springs);
        auto sample = coupled(springs, 108, 0.1, 0.45);
        sample.body.terms.push_back(msm::inversion_guard(body));
        expect_with_energy_what_the_oracle_does(sample);
    }
}

TEST_P(CoupledSprings, GiveTheSameForAnyNumberOfThreads) {
    tests::expect_the_same_for_any_number_of_threads(coupled("nodal_springs", 108, 0.4, 0.45));
    for (const auto *springs : all_with_energy)
        tests::expect_the_same_for_any_number_of_threads(coupled(springs, 108, 0.25, 0.45));
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
