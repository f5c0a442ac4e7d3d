#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/integrator.hpp"
#include "tests/not_a_number.hpp"

namespace livermark {
namespace {

using core::Vector3;
using tests::nan;

/// Equal masses on equal springs in a row between two walls, free along the row:
/// omega_j = 2 sqrt(k / m) sin(j pi / (2 (n + 1))), j = 1 ... n.
struct Chain {
    static constexpr int num_masses = 20;
    static constexpr double mass = 0.003;
    static constexpr double stiffness = 12.0;
    static constexpr double spacing = 0.01;
    core::SpringNetwork springs;
    std::vector<Vector3> positions;
    msm::NodalConditions conditions;

    Chain() {
        constexpr int num_nodes = num_masses + 2;
        for (int i = 0; i < num_nodes; ++i) {
            positions.emplace_back(i * spacing, 0.0, 0.0);
            springs.node_mass.push_back(mass);
            const bool is_wall = i == 0 || i == num_nodes - 1;
            conditions.displacement.emplace_back(is_wall ? 0.0 : nan, 0.0, 0.0);
            // What the observation has to leave out, or everything would move by metres.
            conditions.force.emplace_back(50.0, 0.0, 0.0);
            if (i > 0) {
                springs.edges.push_back({i - 1, i});
                springs.stiffness.push_back(stiffness);
                springs.rest_length.push_back((positions[i] - positions[i - 1]).norm());
            }
        }
    }

    static double omega(int mode) {
        return 2.0 * std::sqrt(stiffness / mass) * std::sin(mode * std::numbers::pi / (2.0 * (num_masses + 1)));
    }

    double observed(const msm::Integrator &integrator, const core::RayleighDamping &damping, double guess) const {
        return msm::observed_time_step(integrator, springs, positions, conditions, damping, guess);
    }
};

double predicted(const msm::Integrator &integrator, const core::RayleighDamping &damping) {
    return msm::critical_time_step(integrator, damping, Chain::omega(1), Chain::omega(Chain::num_masses));
}

std::vector<msm::Integrator> explicit_integrators() {
    std::vector<msm::Integrator> chosen;
    std::ranges::copy_if(msm::all_integrators(), std::back_inserter(chosen), &msm::Integrator::is_explicit);
    return chosen;
}

class ObservedTimeStep : public testing::TestWithParam<msm::Integrator> {};

TEST_P(ObservedTimeStep, IsThePredictedOneOfAChain) {
    const Chain chain;
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
    const Chain chain;
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

} // namespace
} // namespace livermark
