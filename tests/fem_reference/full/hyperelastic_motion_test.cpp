#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/dynamics/mass_matrix.hpp"
#include "fem_reference/dynamics/release.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/hyperelastic/motion/energy_momentum.hpp"
#include "fem_reference/hyperelastic/motion/hyperelastic_motion.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"

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
    Elements elements_of(const std::shared_ptr<const core::Body> &of) const {
        return {of, GetParam(), fem_reference::Formulation::displacement, hyperelastic::material_law("neo_hookean"),
                rule()};
    }

    /// Clamped at one end, pulled at the other, and let go.
    core::LoadCase pulled(const Vector3 &traction, int num_steps, double duration,
                          const core::RayleighDamping &damping) const {
        auto load_case = tests::empty_load_case(body->mesh);
        tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
        tests::pull(load_case, body->mesh, "x_max", traction);
        load_case.release = core::Release{
            num_steps, duration / num_steps, damping, {{"end", body->mesh.num_nodes() - 1}, {"middle", 25}}};
        return load_case;
    }
    core::Solution solve(const core::LoadCase &load_case) const {
        return hyperelastic::solve({body, load_case}, hyperelastic::material_law("neo_hookean"), {.degree = GetParam()},
                                   {.fractions = {0.25, 0.5, 0.75, 1.0}, .tolerance = 1e-11})
            .solution;
    }

    std::shared_ptr<const core::Body> body = swinging_bar();
    const Vector3 hard{0.0, 8.0, 40.0}; ///< bends quadratic elements by more than their thickness [Pa]
};

/// |a - b| / |b| over all of a series of vectors.
double difference_of(const std::vector<Vector3> &a, const std::vector<Vector3> &b) {
    double difference = a.size() == b.size() ? 0.0 : std::numeric_limits<double>::infinity(), size = 0.0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        difference += (a[i] - b[i]).squaredNorm();
        size += b[i].squaredNorm();
    }
    return std::sqrt(difference / size);
}

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
        return difference_of(large.history->displacement, small.displacement);
    };
    const double at_one = difference(4e-3), at_tenth = difference(4e-4);
    RecordProperty("differences", fmt::format("{:.2e} {:.2e}", at_one, at_tenth));
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

/// What is left to the finest steps shrinks by four when steps are halved.
TEST_P(HyperelasticMotion, IsOfSecondOrderInTheStep) {
    const auto motion = [&](int num_steps) {
        const auto solution = solve(pulled(hard, num_steps, 0.5 * period, core::rayleigh_damping(0.05, 15.0, 80.0)));
        EXPECT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
        return *solution.history;
    };
    const auto finest = motion(320);
    std::vector<double> errors;
    for (const int num_steps : {20, 40, 80})
        errors.push_back(difference_of(motion(num_steps).displacement, thinned(finest, 320 / num_steps)));
    RecordProperty("errors", fmt::format("{:.2e}", fmt::join(errors, " ")));
    for (std::size_t k = 1; k < errors.size(); ++k)
        EXPECT_NEAR(std::log2(errors[k - 1] / errors[k]), 2.0, 0.3) << fmt::format("{:.2e}", fmt::join(errors, " "));
}

/// A body that nothing holds, spun and bent: neither forces nor viscosity change momentum and angular momentum.
TEST_P(HyperelasticMotion, KeepsMomentumAndAngularMomentumOfAFreeBody) {
    const auto elements = elements_of(body);
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
    EXPECT_LT(difference_of(elsewhere.history->displacement, expected), 1e-5);
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
    const Elements elements(body, 2, fem_reference::Formulation::mixed, hyperelastic::material_law("neo_hookean"),
                            TetrahedronRule::fourteen_points);
    const std::vector<bool> is_free(elements.num_displacements(), true);
    EXPECT_THROW(EnergyMomentum(elements, TetrahedronRule::fourteen_points, is_free, {}, 1.0), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Degrees, HyperelasticMotion, testing::Values(1, 2));

} // namespace livermark
