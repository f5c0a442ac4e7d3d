#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>

#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/dynamics/release.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/hyperelastic/motion.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/fem_reference/hyperelastic_bodies.hpp"

namespace livermark {

namespace {

using core::Vector3;
using fem_reference::Motion;
using hyperelastic::Elements;
using hyperelastic::EnergyMomentum;
using hyperelastic::TetrahedronRule;

/// A bar that swings about once in 0.4 s.
std::shared_ptr<const core::Body> swinging_bar() {
    return tests::make_body(tests::shaken_box_mesh({0.1, 0.03, 0.02}, {5, 2, 1}), {1060.0, 5000.0, 0.45});
}

constexpr double period = 0.4;

/// Parameter: degree of the elements.
class HyperelasticMotion : public testing::TestWithParam<int> {
  protected:
    TetrahedronRule rule() const {
        return GetParam() == 1 ? TetrahedronRule::one_point : TetrahedronRule::fourteen_points;
    }

    /// Clamped at one end, pulled at the other, and let go.
    core::LoadCase pulled(const Vector3 &traction, int num_steps, double duration,
                          const core::RayleighDamping &damping) const {
        auto load_case = tests::held(body->mesh);
        tests::pull(load_case, body->mesh, "x_max", traction);
        load_case.release = core::Release{
            num_steps, duration / num_steps, damping, {{"end", body->mesh.num_nodes() - 1}, {"middle", 25}}};
        return load_case;
    }
    core::Solution solve(const core::LoadCase &load_case, bool observes_steps = false) const {
        return hyperelastic::solve({body, load_case}, hyperelastic::material_law("neo_hookean"),
                                   {.degree = GetParam(), .observes_steps = observes_steps},
                                   {.fractions = {0.25, 0.5, 0.75, 1.0}, .tolerance = 1e-11})
            .solution;
    }

    std::shared_ptr<const core::Body> body = swinging_bar();
    const Vector3 hard{0.0, 8.0, 40.0}; ///< bends quadratic elements by more than their thickness [Pa]
};

/// Every so many records of two probes.
std::vector<Vector3> thinned(const core::History &history, int factor) {
    std::vector<Vector3> result;
    for (std::size_t k = 0; k < history.time.size(); k += factor)
        for (std::size_t q = 0; q < 2; ++q)
            result.push_back(history.displacement[2 * k + q]);
    return result;
}

/// L = integral of rho x cross v, with consistent mass.
Vector3 angular_momentum(const fem_reference::SymmetricMatrix &mass, const Elements &elements, const Motion &motion) {
    std::vector<double> momentum(motion.velocity.size());
    fem_reference::multiply_mass(mass, motion.velocity, momentum);
    Vector3 sum = Vector3::Zero();
    for (int node = 0; node < elements.system().num_nodes(); ++node) {
        const Vector3 x = elements.system().points[node] + Vector3::Map(&motion.displacement[3 * node]);
        sum += x.cross(Vector3::Map(&momentum[3 * node]));
    }
    return sum;
}

} // namespace

/// As the load goes to zero, so does the difference from Newmark's steps of linear elements, over the motion in
/// proportion to the load; with damping, which is Rayleigh's at small strain.
TEST_P(HyperelasticMotion, IsThatOfLinearElementsUnderSmallLoads) {
    const auto difference = [&](double factor) {
        const auto load_case = pulled(factor * hard, 100, period, core::rayleigh_damping(0.05, 15.0, 80.0));
        const auto large = solve(load_case);
        EXPECT_EQ(large.status, core::SolutionStatus::ok) << large.message;
        const auto system = fem_reference::assemble(*body, GetParam());
        fem_reference::ConstrainedSolver solver(compressed_rows(system.stiffness));
        const auto conditions = fem_reference::dof_conditions(load_case, system);
        const auto small = fem_reference::release_step_by_step(
            *body, system, load_case, solver.solve(conditions.prescribed, conditions.load).displacement);
        EXPECT_EQ(large.history->time, small.time);
        return tests::relative_l2(large.history->displacement, small.displacement);
    };
    const double at_one = difference(4e-3), at_tenth = difference(4e-4);
    EXPECT_LT(at_tenth, 1e-3);
    EXPECT_NEAR(at_one / at_tenth, 10.0, 2.0);
}

/// Bent far and let go, a body without damping keeps its energy to what Newton's method leaves.
TEST_P(HyperelasticMotion, ConservesEnergyWithoutDamping) {
    const auto solution = solve(pulled(hard, 60, 2.0 * period, {}));
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
    EXPECT_GT(solution.displacement.back().norm(), GetParam() == 1 ? 0.008 : 0.025); // linear elements lock
    const auto &history = *solution.history;
    EXPECT_NEAR(history.strain_energy[0], solution.strain_energy, 1e-9 * solution.strain_energy);
    double most_kinetic = 0.0;
    for (std::size_t k = 0; k < history.time.size(); ++k) {
        EXPECT_NEAR(history.kinetic_energy[k] + history.strain_energy[k], history.strain_energy[0],
                    1e-6 * history.strain_energy[0])
            << history.time[k];
        most_kinetic = std::max(most_kinetic, history.kinetic_energy[k]);
    }
    EXPECT_GT(most_kinetic, 0.8 * history.strain_energy[0]);
}

/// In every step, also in such as are far too long.
TEST_P(HyperelasticMotion, LosesEnergyWithDamping) {
    for (const int num_steps : {8, 80}) {
        const auto solution = solve(pulled(hard, num_steps, 2.0 * period, core::rayleigh_damping(0.05, 15.0, 80.0)));
        ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
        const auto &history = *solution.history;
        double before = std::numeric_limits<double>::infinity();
        for (std::size_t k = 0; k < history.time.size(); ++k) {
            const double energy = history.kinetic_energy[k] + history.strain_energy[k];
            EXPECT_LT(energy, before) << num_steps << " steps, " << history.time[k];
            before = energy;
        }
        EXPECT_LT(before, 0.5 * history.strain_energy[0]);
    }
}

/// The difference from the finest steps shrinks by four when steps are halved, and the motion says so where it is
/// asked.
TEST_P(HyperelasticMotion, IsOfSecondOrderInTheStep) {
    const auto motion = [&](int num_steps) {
        const auto solution =
            solve(pulled(hard, num_steps, 0.5 * period, core::rayleigh_damping(0.05, 15.0, 80.0)), num_steps == 80);
        EXPECT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
        return *solution.history;
    };
    const auto finest = motion(320);
    EXPECT_FALSE(finest.observed_error);
    std::vector<double> errors;
    for (const int num_steps : {20, 40, 80})
        errors.push_back(tests::relative_l2(motion(num_steps).displacement, thinned(finest, 320 / num_steps)));
    for (std::size_t k = 1; k < errors.size(); ++k)
        EXPECT_NEAR(std::log2(errors[k - 1] / errors[k]), 2.0, 0.3) << fmt::format("{:.2e}", fmt::join(errors, " "));
    EXPECT_NEAR(motion(80).observed_error.value().relative_l2, errors.back(), 0.3 * errors.back());
}

/// A body that nothing holds, spun and bent: neither forces nor viscosity change momentum and angular momentum.
TEST_P(HyperelasticMotion, KeepsMomentumAndAngularMomentumOfAFreeBody) {
    const auto elements = tests::neo_hookean_elements(body, GetParam());
    const auto &points = elements.system().points;
    const std::vector<bool> is_free(3 * points.size(), true);
    const std::vector<double> nothing(is_free.size(), 0.0);
    const Vector3 spin(0.0, 20.0, 30.0), drift(0.1, 0.0, -0.2);
    Motion motion{nothing, nothing};
    for (std::size_t node = 0; node < points.size(); ++node)
        Vector3::Map(&motion.velocity[3 * node]) =
            drift + spin.cross(points[node]) + Vector3(0.0, 200.0 * points[node].x() * points[node].x(), 0.0);
    const auto mass = fem_reference::consistent_mass(*body, elements.system());
    const auto momentum_of = [&](const Motion &of) {
        std::vector<double> momentum(of.velocity.size());
        fem_reference::multiply_mass(mass, of.velocity, momentum);
        Vector3 sum = Vector3::Zero();
        for (std::size_t node = 0; node < points.size(); ++node)
            sum += Vector3::Map(&momentum[3 * node]);
        return sum;
    };
    const auto at_first = angular_momentum(mass, elements, motion);
    const Vector3 momentum = momentum_of(motion);
    EnergyMomentum steps(elements, rule(), is_free, {0.0, 2e-3}, 1.0, 1e-12);
    double energy = steps.energy(motion).kinetic;
    for (int step = 0; step < 40; ++step) {
        ASSERT_TRUE(steps.advance(motion, nothing, 0.005));
        const auto now = steps.energy(motion);
        EXPECT_LE(now.kinetic + now.strain, energy * (1.0 + 1e-12));
        energy = now.kinetic + now.strain;
    }
    EXPECT_LT((angular_momentum(mass, elements, motion) - at_first).norm(), 1e-8 * at_first.norm());
    EXPECT_LT((momentum_of(motion) - momentum).norm(), 1e-8 * momentum.norm());
}

/// Turned as a whole, all of it, a body moves as before, turned.
TEST_P(HyperelasticMotion, TurnsWithTheBody) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Vector3(1.0, 2.0, -1.0).normalized()).toRotationMatrix();
    const auto load_case = pulled(hard, 30, period, core::rayleigh_damping(0.05, 15.0, 80.0));
    const auto as_it_is = solve(load_case);
    auto turned = *body;
    for (auto &point : turned.mesh.points)
        point = turn * point;
    body = std::make_shared<const core::Body>(std::move(turned));
    const auto elsewhere = solve(pulled(turn * hard, 30, period, core::rayleigh_damping(0.05, 15.0, 80.0)));
    auto expected = as_it_is.history->displacement;
    for (auto &displacement : expected)
        displacement = turn * displacement;
    EXPECT_LT(tests::relative_l2(elsewhere.history->displacement, expected), 1e-5);
}

/// Nothing is let go of a pressure that is there no more, and what is prescribed stays where it is.
TEST_P(HyperelasticMotion, BeginsAtRestAndKeepsWhatIsPrescribed) {
    auto load_case = pulled(hard, 10, 0.1 * period, {});
    tests::prescribe(load_case, body->mesh, "x_min", {0.001, 0.002, 0.003});
    const auto solution = solve(load_case);
    const auto &history = *solution.history;
    EXPECT_EQ(history.displacement[0], solution.displacement[body->mesh.num_nodes() - 1]);
    EXPECT_EQ(history.kinetic_energy[0], 0.0);
    EXPECT_EQ(history.integrator, "energy_momentum");
    ASSERT_EQ(history.frames.size(), 11 * body->mesh.points.size());
    for (int node = 0; node < body->mesh.num_nodes(); ++node)
        if (body->mesh.points[node].x() == 0.0) {
            EXPECT_EQ(history.frames[10 * body->mesh.num_nodes() + node], Eigen::Vector3f(0.001F, 0.002F, 0.003F));
        }
}

TEST(HyperelasticMotionOfMixedElements, IsRefused) {
    const auto body = swinging_bar();
    const auto elements = tests::neo_hookean_elements(body, 2, fem_reference::Formulation::mixed);
    const std::vector<bool> is_free(elements.num_displacements(), true);
    EXPECT_THROW(EnergyMomentum(elements, TetrahedronRule::fourteen_points, is_free, {}, 1.0), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Degrees, HyperelasticMotion, testing::Values(1, 2));

namespace {

/// A block under a ball that sinks in within half a second, slides if it does, and is gone at the end.
core::Problem block_under_a_moving_ball(double friction, const Vector3 &slide) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.1, 0.06}, {3, 3, 2}), tests::soft_material);
    auto load_case = tests::held(body->mesh, "z_min");
    constexpr double radius = 0.04;
    load_case.regime = core::Regime::large;
    load_case.touching = core::TouchingTool{.shape = radius,
                                            .start = {0.05, 0.05, 0.06 + radius},
                                            .press = {0.0, 0.0, -0.005},
                                            .friction = friction,
                                            .constraint = load_case.num_constraints()};
    load_case.tool = core::ToolMotion{.constraint = load_case.touching->constraint,
                                      .press_until = 0.5,
                                      .slide = slide,
                                      .slide_from = 0.6,
                                      .slide_until = 1.1,
                                      .release_at = 1.2,
                                      .num_frames = 36,
                                      .frame_interval = 0.05,
                                      .mass_damping = 20.0};
    load_case.conditions.push_back({"touch", core::ConditionKind::touch});
    load_case.target_peak_displacement = 0.005;
    return {body, load_case};
}

core::ToolHistory moved(const core::Problem &problem, int steps_per_frame) {
    return hyperelastic::move_tool(problem, hyperelastic::material_law("neo_hookean"), 2, steps_per_frame,
                                   hyperelastic::TetrahedronRule::fourteen_points);
}

} // namespace

/// Pressed slowly and held, the body is where statics have it, under the same force; let go, it comes back.
TEST(TouchingMotion, ComesToRestWhereStaticsHaveIt) {
    const auto problem = block_under_a_moving_ball(0.0, Vector3::Zero());
    const auto history = moved(problem, 4);
    ASSERT_EQ(history.time.size(), 37U);
    auto still = problem;
    still.load_case.tool.reset();
    const auto rest = hyperelastic::solve(still, hyperelastic::material_law("neo_hookean"), {.degree = 2},
                                          {.fractions = {0.5, 1.0}, .tolerance = 1e-8});
    ASSERT_EQ(rest.solution.status, core::SolutionStatus::ok) << rest.solution.message;
    // The trapezoidal rule lets the force on a surface that touches go to and fro by up to 3 % while the tool rests.
    constexpr std::ptrdiff_t first_at_rest = 14, let_go = 25;
    const Vector3 expected = -rest.solution.reaction[1];
    const Vector3 found = std::accumulate(history.force.begin() + first_at_rest, history.force.begin() + let_go,
                                          Vector3(Vector3::Zero())) /
                          static_cast<double>(let_go - first_at_rest);
    EXPECT_LT((found - expected).norm(), 0.01 * expected.norm());
    EXPECT_EQ(history.force.back(), Vector3::Zero());
    const std::size_t num_nodes = problem.body->mesh.points.size();
    double left = 0.0;
    for (std::size_t node = 0; node < num_nodes; ++node)
        left = std::max(left, static_cast<double>(history.displacement[9 * num_nodes + node].norm()));
    EXPECT_LT(left, 0.001);
}

/// A ball that slides is held back by friction, in the steps as in statics.
TEST(TouchingMotion, SlidesAgainstFriction) {
    const auto history = moved(block_under_a_moving_ball(0.3, {0.01, 0.0, 0.0}), 8);
    ASSERT_EQ(history.time.size(), 37U);
    const Vector3 while_sliding = history.force[20]; // of the body on the tool
    EXPECT_LT(while_sliding.x(), -0.15 * while_sliding.z());
}

} // namespace livermark
