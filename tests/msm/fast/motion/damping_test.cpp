#include "msm/dynamics/stepper.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "msm/springs/spring_network.hpp"
#include "msm/statics/rest_stiffness.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

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
