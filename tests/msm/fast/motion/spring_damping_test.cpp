#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/integrator.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/spring_network.hpp"
#include "msm/statics/rest_stiffness.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"

namespace livermark {
namespace {

/// How a mode of a rod dies away and how fast it swings, seen in steps of Runge-Kutta that are far below its period.
struct Decay {
    double damping_ratio = 0.0;
    double period_ratio = 0.0; ///< over that without damping
};

class SpringDamping : public testing::TestWithParam<int> {
  protected:
    core::Problem problem;
    core::SpringNetwork springs;
    msm::NodalConditions conditions;
    core::Modes modes;

    void SetUp() override {
        problem.body = tests::make_body(tests::shaken_box_mesh({0.2, 0.05, 0.04}, {6, 2, 2}), {1060.0, 5000.0, 0.25});
        problem.load_case = tests::empty_load_case(problem.body->mesh);
        tests::prescribe(problem.load_case, problem.body->mesh, "x_min", core::Vector3::Zero());
        springs = msm::spring_network(*problem.body, msm::all_spring_laws().front());
        conditions = msm::nodal_conditions(problem, springs.node_mass);
        modes = msm::lowest_modes(springs, problem.body->mesh.points, conditions, 3);
    }

    /// Lets one mode swing from a millionth of the length of the rod, and fits its decay and its period.
    Decay ring(const core::RayleighDamping &damping, int mode) const {
        const auto num_nodes = problem.body->mesh.points.size();
        const auto equation = msm::elastic_motion(springs, problem.body->mesh.points, conditions, damping);
        const std::vector<core::Vector3> field(modes.shape.begin() + static_cast<std::ptrdiff_t>(mode * num_nodes),
                                               modes.shape.begin() +
                                                   static_cast<std::ptrdiff_t>((mode + 1) * num_nodes));
        const Eigen::VectorXd shape = msm::to_unknowns(field);
        const double scale = 2e-7 / shape.lpNorm<Eigen::Infinity>();
        msm::State state{scale * shape, Eigen::VectorXd::Zero(shape.size())};
        const double omega = modes.angular_frequency[mode];
        const double highest = msm::largest_angular_frequency(springs, problem.body->mesh.points, conditions);
        const auto &integrator = msm::find_integrator("runge_kutta_4");
        const double h = std::min(2.0 * std::numbers::pi / omega / 2000.0,
                                  0.5 * msm::critical_time_step(integrator, damping, 0.5 * omega, highest));
        const auto step = integrator.prepare(equation, h);
        // The amplitude of the mode, M-weighted: its zeros give the period, its peaks the decay.
        const Eigen::VectorXd weight = equation.mass.cwiseProduct(shape);
        double before = weight.dot(state.displacement);
        const double first = before;
        std::vector<double> zeros;
        std::vector<double> peaks{first};
        double peak = 0.0;
        for (int n = 1; zeros.size() < 8; ++n) {
            step(state);
            const double now = weight.dot(state.displacement);
            if (before * now <= 0.0) {
                zeros.push_back(h * (n - now / (now - before)));
                if (zeros.size() > 1)
                    peaks.push_back(peak);
                peak = 0.0;
            }
            peak = std::max(peak, std::abs(now));
            before = now;
        }
        // From the peak between two zeros to the one six half periods later: delta = 6 pi zeta / sqrt(1 - zeta^2).
        const double delta = std::log(peaks[1] / peaks[7]) / 6.0 / std::numbers::pi;
        const double period = 2.0 * (zeros.back() - zeros.front()) / 7.0;
        return {delta / std::sqrt(1.0 + delta * delta), period * omega / (2.0 * std::numbers::pi)};
    }
};

} // namespace

/// Damping by the mass, by the stiffness, and by both: each mode has (alpha / omega + beta omega) / 2.
TEST_P(SpringDamping, GivesEachModeItsRatio) {
    const double omega = modes.angular_frequency[GetParam()];
    for (const core::RayleighDamping damping :
         {core::RayleighDamping{0.1 * omega, 0.0}, core::RayleighDamping{0.0, 0.1 / omega},
          core::RayleighDamping{0.06 * omega, 0.14 / omega}}) {
        const double expected = damping.ratio(omega);
        const auto found = ring(damping, GetParam());
        EXPECT_NEAR(found.damping_ratio, expected, 0.01 * expected) << damping.alpha << " " << damping.beta;
        EXPECT_NEAR(found.period_ratio, 1.0 / std::sqrt(1.0 - expected * expected), 1e-3);
    }
}

TEST_P(SpringDamping, LetsAModeRingForEverWithoutDamping) {
    const auto found = ring({}, GetParam());
    EXPECT_NEAR(found.damping_ratio, 0.0, 1e-6);
    EXPECT_NEAR(found.period_ratio, 1.0, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Modes, SpringDamping, testing::Values(0, 1, 2));

} // namespace livermark
