#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/integrator.hpp"
#include "msm/springs/springs.hpp"
#include "msm/statics/rest_stiffness.hpp"
#include "tests/bad_input.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/not_a_number.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

using tests::nan;

struct Springs {
    core::SpringNetwork network;
    std::vector<Vector3> positions;
    msm::NodalConditions conditions;
};

constexpr double chain_stiffness = 3.0;
constexpr double chain_mass = 0.02;

/// Equal masses on a line between two walls, free along the line only.
Springs chain(int num_masses, double stiffness = chain_stiffness, double mass = chain_mass, double spacing = 0.1) {
    Springs springs;
    for (int i = 0; i <= num_masses + 1; ++i) {
        const bool is_wall = i == 0 || i == num_masses + 1;
        springs.positions.emplace_back(spacing * i, 0.0, 0.0);
        springs.network.node_mass.push_back(mass);
        springs.conditions.displacement.emplace_back(is_wall ? 0.0 : nan, 0.0, 0.0);
        if (i > 0) {
            springs.network.edges.push_back({i - 1, i});
            springs.network.stiffness.push_back(stiffness);
            springs.network.rest_length.push_back((springs.positions[i] - springs.positions[i - 1]).norm());
        }
    }
    return springs;
}

/// omega_j = 2 sqrt(k / m) sin(j pi / (2 (n + 1)))
double chain_frequency(int mode, int num_masses, double stiffness = chain_stiffness, double mass = chain_mass) {
    return 2.0 * std::sqrt(stiffness / mass) * std::sin(mode * std::numbers::pi / (2.0 * (num_masses + 1)));
}

enum class Constrained { nothing, side, rollers };

/// A box without symmetry whose springs differ by a factor of six and its masses by two.
Springs shaken_springs(Constrained constrained) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.08, 0.06}, {4, 3, 3}), {1060.0, 5000.0, 0.25});
    Springs springs{msm::spring_network(*body, msm::all_spring_laws().front()), body->mesh.points, {}};
    for (std::size_t s = 0; s < springs.network.stiffness.size(); ++s)
        springs.network.stiffness[s] *= 1.0 + static_cast<double>(s * s % 6);
    for (std::size_t i = 0; i < springs.network.node_mass.size(); ++i)
        springs.network.node_mass[i] *= 1.0 + static_cast<double>(i * i % 2);
    springs.conditions.displacement.assign(springs.positions.size(), Vector3::Constant(nan));
    for (std::size_t i = 0; i < springs.positions.size(); ++i)
        for (int c = 0; c < 3; ++c)
            if ((constrained == Constrained::side && springs.positions[i].x() == 0.0) ||
                (constrained == Constrained::rollers && springs.positions[i][c] == 0.0))
                springs.conditions.displacement[i][c] = 0.001; // is constrained at zero all the same
    return springs;
}

/// All frequencies, from the second derivative of the energy as a full matrix.
Eigen::VectorXd dense_frequencies(const Springs &springs) {
    const msm::FreeComponents free(springs.conditions.displacement);
    std::vector<Vector3> mass;
    for (const double m : springs.network.node_mass)
        mass.emplace_back(Vector3::Constant(m));
    const Eigen::MatrixXd stiffness =
        free.restrict(msm::elastic_hessian(springs.network, springs.positions, msm::Tangent::exact));
    const Eigen::MatrixXd full_mass = free.gather(mass).asDiagonal();
    return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(stiffness, full_mass, Eigen::EigenvaluesOnly)
        .eigenvalues()
        .cwiseMax(0.0)
        .cwiseSqrt();
}

core::Modes lowest(const Springs &springs, int count) {
    return msm::lowest_modes(springs.network, springs.positions, springs.conditions, count);
}

double largest_frequency(const Springs &springs) {
    return msm::largest_angular_frequency(springs.network, springs.positions, springs.conditions);
}

double bound(const Springs &springs) {
    return msm::gershgorin_angular_frequency(springs.network, springs.positions, springs.conditions);
}

/// The chain of 1000 has its two largest frequencies 4e-6 apart.
TEST(SpringSpectrum, OfAChainIsTheKnownOne) {
    for (const int num_masses : {6, 12, 100}) {
        const auto modes = lowest(chain(num_masses), 5);
        ASSERT_EQ(modes.count(), 5);
        for (int mode = 1; mode <= 5; ++mode)
            EXPECT_NEAR(modes.angular_frequency[mode - 1] / chain_frequency(mode, num_masses), 1.0, 1e-10);
    }
    for (const int num_masses : {1, 2, 40, 41, 300, 1000})
        EXPECT_NEAR(largest_frequency(chain(num_masses)) / chain_frequency(num_masses, num_masses), 1.0, 1e-9)
            << num_masses;
}

TEST(SpringSpectrum, IsThatOfTheFullMatrix) {
    for (const auto constrained : {Constrained::nothing, Constrained::side, Constrained::rollers}) {
        const auto springs = shaken_springs(constrained);
        const auto expected = dense_frequencies(springs);
        EXPECT_NEAR(largest_frequency(springs) / expected[expected.size() - 1], 1.0, 1e-9);
        if (constrained == Constrained::nothing)
            continue; // lowest modes are refused
        const auto modes = lowest(springs, 20);
        for (int mode = 0; mode < 20; ++mode)
            EXPECT_NEAR(modes.angular_frequency[mode] / expected[mode], 1.0, 1e-10) << mode;
    }
}

/// Constrained at its side, the box has another highest mode than free, or not, depending on where it is.
TEST(SpringSpectrum, LargestFrequencyIsFoundFromTheBodyConstrainedLess) {
    const auto free = shaken_springs(Constrained::nothing);
    const auto mode = msm::highest_mode(free.network, free.positions, free.conditions);
    EXPECT_EQ(mode.angular_frequency, largest_frequency(free));
    EXPECT_NEAR(mode.shape.norm(), 1.0, 1e-12);
    for (const auto constrained : {Constrained::nothing, Constrained::side, Constrained::rollers}) {
        const auto springs = shaken_springs(constrained);
        const double found =
            msm::largest_angular_frequency(springs.network, springs.positions, springs.conditions, mode);
        EXPECT_NEAR(found / largest_frequency(springs), 1.0, 1e-9);
    }
}

/// A stiff spring near one end swings by itself: whether its mode is looked for again depends on what is constrained.
TEST(SpringSpectrum, LocalHighestModeIsThatOfTheBodyConstrainedMore) {
    auto springs = chain(60);
    springs.network.stiffness[50] *= 100.0;
    springs.conditions.displacement.front().setConstant(nan);
    springs.conditions.displacement.back().setConstant(nan);
    const auto constrained_at = [&](std::size_t node) {
        auto conditions = springs.conditions;
        conditions.displacement[node].setZero();
        return conditions;
    };
    const auto alone = [&](const msm::NodalConditions &conditions) {
        return msm::largest_angular_frequency(springs.network, springs.positions, conditions);
    };
    const auto free = msm::highest_mode(springs.network, springs.positions, springs.conditions);
    const auto by_mode = [&](const msm::NodalConditions &conditions, const msm::HighestMode &mode) {
        return msm::largest_angular_frequency(springs.network, springs.positions, conditions, mode);
    };
    EXPECT_EQ(by_mode(constrained_at(30), free), free.angular_frequency); // as far away as to leave a part of 1e-30
    EXPECT_LT(by_mode(constrained_at(50), free), 0.9 * free.angular_frequency);
    EXPECT_EQ(by_mode(constrained_at(50), free), alone(constrained_at(50)));
    // The mode of what is constrained elsewhere says nothing, even if its frequency is lower.
    const auto elsewhere = msm::highest_mode(springs.network, springs.positions, constrained_at(50));
    EXPECT_EQ(by_mode(constrained_at(30), elsewhere), alone(constrained_at(30)));
    auto all_constrained = springs.conditions;
    for (auto &displacement : all_constrained.displacement)
        displacement.setZero();
    EXPECT_EQ(by_mode(all_constrained, free), 0.0);
}

/// K phi = omega^2 M phi on the free components, zero on the constrained ones, and phi^T M psi = 1 or 0.
TEST(SpringSpectrum, ShapesSolveTheEigenproblem) {
    const auto springs = shaken_springs(Constrained::rollers);
    const auto modes = lowest(springs, 8);
    const auto num_nodes = springs.positions.size();
    ASSERT_EQ(modes.shape.size(), 8 * num_nodes);
    const auto stiffness = msm::elastic_hessian(springs.network, springs.positions, msm::Tangent::exact);
    Eigen::MatrixXd shape(3 * num_nodes, 8);
    Eigen::VectorXd mass(3 * num_nodes);
    for (std::size_t i = 0; i < num_nodes; ++i) {
        mass.segment<3>(3 * i).setConstant(springs.network.node_mass[i]);
        for (int mode = 0; mode < 8; ++mode)
            shape.col(mode).segment<3>(3 * i) = modes.shape[mode * num_nodes + i];
    }
    EXPECT_LT((shape.transpose() * mass.asDiagonal() * shape - Eigen::MatrixXd::Identity(8, 8)).norm(), 1e-9);
    for (int mode = 0; mode < 8; ++mode) {
        const double square = std::pow(modes.angular_frequency[mode], 2);
        const Eigen::VectorXd inertia = square * mass.cwiseProduct(shape.col(mode));
        const Eigen::VectorXd residual = stiffness * shape.col(mode) - inertia;
        EXPECT_EQ(shape.col(mode).cwiseAbs().maxCoeff(), shape.col(mode).maxCoeff()) << "the sign is left to chance";
        for (std::size_t i = 0; i < num_nodes; ++i)
            for (int c = 0; c < 3; ++c)
                if (std::isnan(springs.conditions.displacement[i][c]))
                    EXPECT_NEAR(residual[3 * i + c], 0.0, 1e-8 * inertia.norm());
                else
                    EXPECT_EQ(shape(3 * i + c, mode), 0.0);
    }
}

/// Two equal networks that do not touch have every frequency twice.
TEST(SpringSpectrum, FindsBothCopiesOfARepeatedFrequency) {
    auto twins = shaken_springs(Constrained::side);
    const auto one = twins;
    const int shift = static_cast<int>(one.positions.size());
    for (const auto &[i, j] : one.network.edges)
        twins.network.edges.push_back({i + shift, j + shift});
    const auto append = [](auto &to, const auto &from) { to.insert(to.end(), from.begin(), from.end()); };
    append(twins.positions, one.positions);
    append(twins.network.node_mass, one.network.node_mass);
    append(twins.network.stiffness, one.network.stiffness);
    append(twins.network.rest_length, one.network.rest_length);
    append(twins.conditions.displacement, one.conditions.displacement);
    const auto single = lowest(one, 5);
    const auto modes = lowest(twins, 9);
    for (int mode = 0; mode < 9; ++mode)
        EXPECT_NEAR(modes.angular_frequency[mode] / single.angular_frequency[mode / 2], 1.0, 1e-10) << mode;
    EXPECT_NEAR(largest_frequency(twins) / largest_frequency(one), 1.0, 1e-9);
}

TEST(SpringSpectrum, BoundIsAboveTheLargestFrequencyAndBelowTheRowSums) {
    for (const auto constrained : {Constrained::nothing, Constrained::side, Constrained::rollers}) {
        const auto springs = shaken_springs(constrained);
        std::vector<double> row_sum(springs.positions.size(), 0.0);
        for (std::size_t s = 0; s < springs.network.edges.size(); ++s)
            for (const int node : springs.network.edges[s])
                row_sum[node] += 2.0 * springs.network.stiffness[s] / springs.network.node_mass[node];
        EXPECT_GE(bound(springs), largest_frequency(springs));
        EXPECT_LT(bound(springs), 2.0 * largest_frequency(springs));
        EXPECT_LE(bound(springs), std::sqrt(*std::ranges::max_element(row_sum)));
    }
    // Where neighbours swing against each other there is nothing between the bound and the frequency.
    EXPECT_GE(bound(chain(300)), largest_frequency(chain(300)));
    EXPECT_NEAR(bound(chain(300)), 2.0 * std::sqrt(chain_stiffness / chain_mass), 1e-12);
}

TEST(ExplicitSteps, ConstrainedOtherwiseAreLongerOrShorterButTakeAsLong) {
    const auto springs = shaken_springs(Constrained::side);
    const double highest = largest_frequency(springs);
    const auto steps = msm::explicit_steps(springs.network, springs.positions, springs.conditions, highest);
    EXPECT_NEAR(steps.critical_time_step, 2.0 / highest, 1e-12 * steps.critical_time_step);
    EXPECT_GT(steps.seconds_per_step, 0.0);
    const auto others = msm::constrained_otherwise(steps, 4.0 * highest);
    EXPECT_NEAR(others.critical_time_step, 0.25 * steps.critical_time_step, 1e-12 * steps.critical_time_step);
    EXPECT_EQ(others.seconds_per_step, steps.seconds_per_step);
    EXPECT_EQ(others.kernel, steps.kernel);
    EXPECT_EQ(msm::constrained_otherwise(steps, 0.0).critical_time_step, std::numeric_limits<double>::infinity());
}

TEST(SpringSpectrum, OfSpringsThatAreConstrainedEverywhereIsEmpty) {
    auto springs = chain(5);
    for (auto &displacement : springs.conditions.displacement)
        displacement.setZero();
    EXPECT_EQ(largest_frequency(springs), 0.0);
    EXPECT_EQ(bound(springs), 0.0);
    tests::expect_input_error([&] { lowest(springs, 1); }, {"0 free unknowns", "fewer than that"});
}

TEST(SpringSpectrum, RefusesSpringsThatAreFreeToMoveAndMoreModesThanThereAre) {
    auto hinged = shaken_springs(Constrained::nothing);
    for (const std::size_t node : {0U, 1U}) // it can still turn about the line between them
        hinged.conditions.displacement[node].setZero();
    for (const auto &loose : {shaken_springs(Constrained::nothing), hinged})
        tests::expect_input_error([&] { lowest(loose, 3); }, {"free to move", "constrain all six"});
    EXPECT_EQ(lowest(chain(6), 5).count(), 5);
    tests::expect_input_error([] { lowest(chain(6), 6); }, {"6 free unknowns", "the 6 modes", "fewer than that"});
    tests::expect_input_error([] { lowest(chain(6), 0); }, {"at least one"});
}

/// A chain whose loads the observation has to leave out, or everything would move by metres.
struct Chain {
    static constexpr int num_masses = 20;
    static constexpr double mass = 0.003, stiffness = 12.0;
    Springs springs = chain(num_masses, stiffness, mass, 0.01);

    double observed(const msm::Integrator &integrator, const core::RayleighDamping &damping, double guess) {
        springs.conditions.force.assign(springs.positions.size(), {50.0, 0.0, 0.0});
        return msm::observed_time_step(integrator, springs.network, springs.positions, springs.conditions, damping,
                                       guess);
    }
};

double predicted(const msm::Integrator &integrator, const core::RayleighDamping &damping) {
    const auto omega = [](int mode) { return chain_frequency(mode, Chain::num_masses, Chain::stiffness, Chain::mass); };
    return msm::critical_time_step(integrator, damping, omega(1), omega(Chain::num_masses));
}

std::vector<msm::Integrator> explicit_integrators() {
    std::vector<msm::Integrator> chosen;
    std::ranges::copy_if(msm::all_integrators(), std::back_inserter(chosen), &msm::Integrator::is_explicit);
    return chosen;
}

class ObservedTimeStep : public testing::TestWithParam<msm::Integrator> {};

TEST_P(ObservedTimeStep, IsThePredictedOneOfAChain) {
    Chain chain;
    const core::RayleighDamping light{.alpha = 3.0, .beta = 0.005}, heavy{.alpha = 0.5, .beta = 0.02};
    for (const auto &damping : {core::RayleighDamping{}, light, heavy}) {
        const double expected = predicted(GetParam(), damping);
        if (expected == 0.0)
            continue; // no limit: every step grows, and the smaller the slower
        EXPECT_NEAR(chain.observed(GetParam(), damping, expected), expected, 0.01 * expected)
            << "alpha " << damping.alpha << ", beta " << damping.beta;
    }
}

TEST_P(ObservedTimeStep, DoesNotDependOnTheGuess) {
    Chain chain;
    const core::RayleighDamping damping{.alpha = 0.5, .beta = 0.01};
    const double expected = predicted(GetParam(), damping);
    const double near = chain.observed(GetParam(), damping, expected);
    EXPECT_EQ(chain.observed(GetParam(), damping, 0.03 * expected), near);
    EXPECT_EQ(chain.observed(GetParam(), damping, 30.0 * expected), near);
}

INSTANTIATE_TEST_SUITE_P(Explicit, ObservedTimeStep, testing::ValuesIn(explicit_integrators()),
                         [](const auto &info) { return info.param.name; });

TEST(ObservedTimeStepOfImplicitEuler, HasNoUpperEnd) {
    const auto &integrator = msm::all_implicit_integrators().front();
    EXPECT_EQ(Chain().observed(integrator, {}, 0.01), std::numeric_limits<double>::infinity());
}

void expect_ratio(const core::RayleighDamping &damping, double omega, double ratio) {
    EXPECT_NEAR(damping.ratio(omega) / ratio, 1.0, 1e-12);
    EXPECT_GE(damping.alpha, 0.0);
    EXPECT_GE(damping.beta, 0.0);
}

TEST(Damping, HasTheRatioThatWasAskedForAtTheFrequencyOfEach) {
    expect_ratio(msm::mass_proportional_damping(0.05, 11.0), 11.0, 0.05);
    expect_ratio(msm::stiffness_proportional_damping(0.05, 11.0), 11.0, 0.05);
    for (const auto &[first, second] : {std::pair{0.05, 0.05}, {0.05, 0.02}, {0.02, 0.1}}) {
        const auto damping = msm::two_mode_damping(first, 11.0, second, 63.0);
        expect_ratio(damping, 11.0, first);
        expect_ratio(damping, 63.0, second);
        const auto swapped = msm::two_mode_damping(second, 63.0, first, 11.0);
        EXPECT_NEAR(swapped.alpha, damping.alpha, 1e-12 * damping.alpha);
        EXPECT_NEAR(swapped.beta, damping.beta, 1e-12 * damping.beta);
    }
    const auto at_both = core::rayleigh_damping(0.05, 11.0, 63.0);
    expect_ratio(at_both, 11.0, 0.05);
    expect_ratio(at_both, 63.0, 0.05);
    EXPECT_LT(at_both.ratio(30.0), 0.05);
}

/// phi^T D phi = 2 zeta omega with D made of a dashpot along each spring and a damper at each node: they are Rayleigh's
/// on every mode.
TEST(Damping, OfSpringsAndNodesGivesEveryModeItsRatio) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.08, 0.06}, {4, 3, 3}), {1060.0, 5000.0, 0.25});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    const auto &law = msm::all_spring_laws().front();
    const auto &points = body->mesh.points;
    const auto springs = msm::spring_network(*body, law);
    const auto modes =
        msm::lowest_modes(springs, points, msm::nodal_conditions({body, load_case}, springs.node_mass), 6);
    const auto damping = msm::two_mode_damping(0.05, modes.angular_frequency[0], 0.03, modes.angular_frequency[4]);
    for (int mode = 0; mode < 6; ++mode) {
        const auto *shape = &modes.shape[mode * points.size()];
        double power = 0.0; // of a motion with the velocities phi
        for (std::size_t i = 0; i < points.size(); ++i)
            power += damping.alpha * springs.node_mass[i] * shape[i].squaredNorm();
        for (std::size_t s = 0; s < springs.edges.size(); ++s) {
            const auto [i, j] = springs.edges[s];
            power += damping.beta * springs.stiffness[s] *
                     std::pow((points[j] - points[i]).normalized().dot(shape[j] - shape[i]), 2);
        }
        const double omega = modes.angular_frequency[mode];
        EXPECT_NEAR(power / (2.0 * omega) / damping.ratio(omega), 1.0, 1e-9);
        if (mode == 0 || mode == 4) {
            EXPECT_NEAR(power / (2.0 * omega) / (mode == 0 ? 0.05 : 0.03), 1.0, 1e-9);
        }
    }
}

TEST(Damping, RefusesWhatNoDampingCanBe) {
    tests::expect_input_error([] { msm::mass_proportional_damping(-0.1, 1.0); }, {"-0.1", "zero or more"});
    tests::expect_input_error([] { msm::stiffness_proportional_damping(0.1, 0.0); }, {"has to be positive"});
    tests::expect_input_error([] { msm::mass_proportional_damping(std::nan(""), 1.0); }, {"zero or more"});
    tests::expect_input_error([] { msm::stiffness_proportional_damping(0.1, std::numeric_limits<double>::infinity()); },
                              {"positive"});
    tests::expect_input_error([] { msm::two_mode_damping(0.1, 2.0, 0.1, 2.0); }, {"frequencies that differ"});
    tests::expect_input_error([] { msm::two_mode_damping(0.01, 1.0, 0.1, 2.0); }, {"negative alpha"});
    tests::expect_input_error([] { msm::two_mode_damping(0.1, 1.0, 0.01, 2.0); }, {"negative beta"});
}

} // namespace
} // namespace livermark
