#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/dynamics/release.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"

namespace livermark {

namespace {

using core::Vector3;
using fem_reference::RitzSpace;

/// A body that is pulled, and let go from where that brings it. No copies: the matrices are referred to.
struct PulledBody {
    PulledBody(std::shared_ptr<const core::Body> of, int degree, const core::LoadCase &remaining_)
        : body(std::move(of)), remaining(remaining_), pulled(remaining_),
          system(fem_reference::assemble(*body, degree)), mass(fem_reference::consistent_mass(*body, system)),
          solver(compressed_rows(system.stiffness)) {
        tests::pull(pulled, body->mesh, "x_max", {0.3, 0.2, 0.1});
        const auto before = fem_reference::dof_conditions(pulled, system);
        conditions = fem_reference::dof_conditions(core::without_tractions(pulled), system);
        start = solver.solve(before.prescribed, before.load).displacement;
        rest = solver.solve(conditions.prescribed, conditions.load).displacement;
        pairs = fem_reference::lowest_eigenpairs(compressed_rows(system.stiffness), mass, conditions.prescribed, 3);
        let_go(300, 1.0 / 60.0, 0.05);
    }
    PulledBody(const PulledBody &) = delete;
    PulledBody &operator=(const PulledBody &) = delete;

    /// @param part   of the first period, that a step is long
    /// @param ratio  of damping, at the first frequency and at six times that
    void let_go(int num_steps, double part, double ratio) {
        const double first = pairs.angular_frequency[0];
        const std::vector<core::Probe> probes{{"middle", body->mesh.num_nodes() / 2},
                                              {"end", body->mesh.num_nodes() - 1}};
        pulled.release = core::Release{num_steps, part * 2.0 * std::numbers::pi / first,
                                       core::rayleigh_damping(ratio, first, 6.0 * first), probes};
    }

    RitzSpace space() {
        std::vector<double> force(start.size());
        system.stiffness.multiply(start, force);
        for (std::size_t i = 0; i < force.size(); ++i)
            force[i] = conditions.load[i] - force[i];
        return {system.stiffness, mass, solver, std::move(force)};
    }
    core::History fast() const {
        fem_reference::ConstrainedSolver solver(compressed_rows(system.stiffness));
        return fem_reference::release(*body, system, pulled, start, solver);
    }
    core::History slow() const { return fem_reference::release_step_by_step(*body, system, pulled, start); }

    std::shared_ptr<const core::Body> body;
    core::LoadCase remaining, pulled;
    fem_reference::ElasticSystem system;
    fem_reference::SymmetricMatrix mass;
    fem_reference::ConstrainedSolver solver;
    fem_reference::DofConditions conditions;
    std::vector<double> start, rest;
    fem_reference::EigenPairs pairs;
};

/// A beam that is neither slender nor symmetric.
std::shared_ptr<const core::Body> swinging_beam(const std::array<int, 3> &bricks = {10, 3, 2}) {
    return tests::make_body(tests::shaken_box_mesh({0.1, 0.03, 0.02}, bricks), {1060.0, 5000.0, 0.45});
}

core::LoadCase constrained(const core::Body &body, const Vector3 &where = Vector3::Zero()) {
    auto load_case = tests::empty_load_case(body.mesh);
    tests::prescribe(load_case, body.mesh, "x_min", where);
    return load_case;
}

/// Under gravity, what is constrained moved.
core::LoadCase constrained_elsewhere(const core::Body &body) {
    auto load_case = constrained(body, {0.0, 0.0, 0.001});
    load_case.acceleration = {0.0, 0.0, -0.05};
    return load_case;
}

/// Of the probes, as a history has it, in a space as it is.
std::vector<Vector3> motion_of_probes(const RitzSpace &space, const PulledBody &pulled) {
    const auto &release = *pulled.pulled.release;
    auto motion = fem_reference::motion_in(space, space.size(), release);
    std::vector<Vector3> found;
    for (int step = 0; step <= release.num_steps; ++step) {
        for (const auto &probe : release.probes) {
            const auto first = 3 * static_cast<Eigen::Index>(probe.node);
            found.emplace_back(Vector3::Map(&pulled.start[first]) +
                               space.vectors().middleRows<3>(first) * motion.displacement());
        }
        motion.advance();
    }
    return found;
}

/// |a - b| / |b| over all of a series of vectors or numbers.
template <class Series> double relative_l2(const Series &a, const Series &b) {
    double difference = a.size() == b.size() ? 0.0 : std::numeric_limits<double>::infinity(), size = 0.0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        if constexpr (std::is_same_v<typename Series::value_type, double>) {
            difference += (a[i] - b[i]) * (a[i] - b[i]);
            size += b[i] * b[i];
        } else {
            difference += (a[i] - b[i]).squaredNorm();
            size += b[i].squaredNorm();
        }
    return std::sqrt(difference / size);
}

void expect_same_motion(const core::History &fast, const core::History &slow, double tolerance) {
    EXPECT_EQ(fast.time, slow.time);
    EXPECT_EQ(fast.integrator, slow.integrator);
    EXPECT_EQ(fast.time_step, slow.time_step);
    EXPECT_LT(relative_l2(fast.displacement, slow.displacement), tolerance);
    EXPECT_LT(relative_l2(fast.frames, slow.frames), std::max(tolerance, 1e-7)); // of single precision
    EXPECT_LT(relative_l2(fast.kinetic_energy, slow.kinetic_energy), tolerance);
    EXPECT_LT(relative_l2(fast.strain_energy, slow.strain_energy), tolerance);
}

/// Parameter: degree of the elements.
class FemRitzMotion : public testing::TestWithParam<int> {};

} // namespace

/// Of a stiffness that is there in its solutions only.
TEST_P(FemRitzMotion, IsTheSameBySolutionsAlone) {
    const auto body = swinging_beam();
    for (const auto &remaining : {constrained(*body), constrained_elsewhere(*body)}) {
        PulledBody pulled(body, GetParam(), remaining);
        auto at_zero = pulled.conditions.prescribed;
        for (double &value : at_zero)
            value = std::isnan(value) ? value : 0.0;
        std::vector<double> force(pulled.start.size());
        pulled.system.stiffness.multiply(pulled.start, force);
        const auto by_statics = fem_reference::release_by_statics(
            *body, pulled.system, pulled.pulled, pulled.start, force,
            [&](std::span<const double> f, std::span<double> x, std::span<double> k_x) {
                const auto found = pulled.solver.solve(at_zero, f);
                for (std::size_t i = 0; i < f.size(); ++i) {
                    x[i] = found.displacement[i];
                    k_x[i] = f[i] + found.residual[i];
                }
            });
        ASSERT_TRUE(by_statics);
        expect_same_motion(*by_statics, pulled.slow(), 1e-4);
    }
}

/// Beside steps of the whole body that are so short that they cost nothing.
TEST(FemRitzSteps, CostTheProbesWhatTheMotionSays) {
    const auto body = swinging_beam({5, 2, 2});
    PulledBody pulled(body, 1, constrained(*body));
    const auto history = pulled.fast();
    ASSERT_TRUE(history.observed_error);
    constexpr int finer = 16;
    pulled.let_go(300 * finer, 1.0 / 60.0 / finer, 0.05);
    const auto fine = pulled.slow();
    EXPECT_FALSE(fine.observed_error);
    const std::size_t num_probes = pulled.pulled.release->probes.size();
    std::vector<Vector3> expected;
    for (std::size_t record = 0; record < history.time.size(); ++record)
        for (std::size_t q = 0; q < num_probes; ++q)
            expected.push_back(fine.displacement[record * finer * num_probes + q]);
    const double error = relative_l2(history.displacement, expected);
    EXPECT_GT(error, 1e-4);
    EXPECT_NEAR(history.observed_error->relative_l2, error, 0.05 * error);
    EXPECT_NEAR(history.observed_error->order, 2.0, 0.2);
}

/// Mixed elements agree with displacements alone where nothing locks, and begin at their own static solution.
TEST(FemMixedMotion, IsThatOfDisplacementsAloneWhereNothingLocks) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.03, 0.02}, {10, 3, 2}), {1060.0, 5000.0, 0.35});
    auto load_case = constrained(*body);
    tests::pull(load_case, body->mesh, "x_max", {0.3, 0.2, 0.1});
    load_case.release =
        core::Release{300, 0.002, core::rayleigh_damping(0.05, 12.0, 70.0), {{"end", body->mesh.num_nodes() - 1}}};
    using fem_reference::Formulation;
    fem_reference::StaticSolver alone(body, 2),
        mixed(body, 2, fem_reference::SolverChoice::automatic, Formulation::mixed);
    const auto expected = alone.solve(load_case), found = mixed.solve_with_motion(load_case);
    EXPECT_FALSE(mixed.solve(load_case).history);
    ASSERT_TRUE(found.history);
    EXPECT_EQ(found.history->displacement[0], found.displacement.back());
    EXPECT_NEAR(found.history->strain_energy[0], found.strain_energy, 1e-6 * found.strain_energy);
    EXPECT_LT(relative_l2(found.history->displacement, expected.history->displacement), 0.03);
    EXPECT_GT(relative_l2(found.history->displacement, expected.history->displacement), 1e-6);
    double before = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < found.history->time.size(); ++k) {
        const double energy = found.history->kinetic_energy[k] + found.history->strain_energy[k];
        EXPECT_LT(energy, before * (1.0 + 1e-6));
        before = energy;
    }
}

TEST_P(FemRitzMotion, IsThatOfStepsOfTheWholeBody) {
    const auto body = swinging_beam();
    for (const auto &remaining : {constrained(*body), constrained_elsewhere(*body)}) {
        PulledBody pulled(body, GetParam(), remaining);
        auto space = pulled.space();
        ASSERT_TRUE(
            fem_reference::extend_until_converged(space, *pulled.pulled.release)); // and no steps of the whole body
        EXPECT_LT(space.size(), 100);
        expect_same_motion(pulled.fast(), pulled.slow(), 1e-4);
        RecordProperty("num_vectors", static_cast<int>(space.size()));
    }
}

TEST_P(FemRitzMotion, IsLeftToStepsOfTheWholeBodyWhereItTakesTooManyVectors) {
    const auto body = swinging_beam();
    PulledBody pulled(body, GetParam(), constrained_elsewhere(*body));
    const auto expect_steps = [&](Eigen::Index most_vectors) {
        auto space = pulled.space();
        EXPECT_FALSE(fem_reference::extend_until_converged(space, *pulled.pulled.release));
        EXPECT_LE(space.size(), most_vectors);
        const auto fast = pulled.fast(), slow = pulled.slow();
        EXPECT_EQ(fast.displacement, slow.displacement);
        EXPECT_EQ(fast.strain_energy, slow.strain_energy);
    };
    pulled.let_go(300, 1.0 / 60.0, 0.0); // without damping, all the high modes that the release excites stay
    expect_steps(100);
    pulled.let_go(8, 1.0 / 60.0, 0.05); // so few steps are done before the space is found
    expect_steps(4);
}

TEST_P(FemRitzMotion, OfThreeModesIsExactInThreeVectors) {
    const auto body = swinging_beam();
    PulledBody pulled(body, GetParam(), constrained_elsewhere(*body));
    pulled.start = pulled.rest;
    for (int mode = 0; mode < 3; ++mode)
        for (std::size_t i = 0; i < pulled.start.size(); ++i)
            pulled.start[i] += 1e-4 * pulled.pairs.shape[mode][i];
    for (const double ratio : {0.0, 0.05, 2.0}) { // the last one overdamped
        pulled.let_go(300, 1.0 / 60.0, ratio);
        auto space = pulled.space();
        while (space.size() < 3)
            ASSERT_TRUE(space.extend());
        const auto slow = pulled.slow();
        EXPECT_LT(relative_l2(motion_of_probes(space, pulled), slow.displacement), 1e-8);
        expect_same_motion(pulled.fast(), slow, 1e-8);
    }
}

TEST_P(FemRitzMotion, HasNoMoreVectorsThanUnknownsAndIsExactWithThem) {
    const auto body = swinging_beam({2, 1, 1});
    PulledBody pulled(body, GetParam(), constrained_elsewhere(*body));
    pulled.let_go(1000, 1.0 / 60.0, 0.0);
    const auto num_free =
        std::ranges::count_if(pulled.conditions.prescribed, [](double value) { return std::isnan(value); });
    auto space = pulled.space();
    while (space.extend())
        ASSERT_LE(space.size(), num_free);
    EXPECT_FALSE(space.extend());
    const auto slow = pulled.slow();
    EXPECT_LT(relative_l2(motion_of_probes(space, pulled), slow.displacement), 1e-9);
    expect_same_motion(pulled.fast(), slow, 1e-4);
}

TEST_P(FemRitzMotion, SpaceIsOrthonormalAndBeginsWithTheStaticSolution) {
    const auto body = swinging_beam();
    PulledBody pulled(body, GetParam(), constrained_elsewhere(*body));
    auto space = pulled.space();
    const int size = 60;
    while (space.size() < size)
        ASSERT_TRUE(space.extend());
    const auto vectors = space.vectors();
    const auto times = [&](const auto &multiply) {
        std::vector<double> in(pulled.start.size()), out(in.size());
        Eigen::MatrixXd product(vectors.rows(), size);
        for (int j = 0; j < size; ++j) {
            Eigen::VectorXd::Map(in.data(), vectors.rows()) = vectors.col(j);
            multiply(in, out);
            product.col(j) = Eigen::VectorXd::Map(out.data(), vectors.rows());
        }
        return product;
    };
    const Eigen::MatrixXd gram = vectors.transpose() * times([&](const auto &x, auto &out) {
                                     fem_reference::multiply_mass(pulled.mass, x, out);
                                 });
    EXPECT_LT((gram - Eigen::MatrixXd::Identity(size, size)).cwiseAbs().maxCoeff(), 1e-12);
    const Eigen::MatrixXd stiffness =
        vectors.transpose() * times([&](const auto &x, auto &out) { pulled.system.stiffness.multiply(x, out); });
    EXPECT_LT((stiffness - space.stiffness()).norm(), 1e-12 * stiffness.norm());
    EXPECT_EQ(space.stiffness(), space.stiffness().transpose());

    const Eigen::VectorXd way = Eigen::VectorXd::Map(pulled.rest.data(), vectors.rows()) -
                                Eigen::VectorXd::Map(pulled.start.data(), vectors.rows());
    EXPECT_LT((vectors.col(0) * (way.dot(vectors.col(0)) / vectors.col(0).squaredNorm()) - way).norm(),
              1e-9 * way.norm());
    for (Eigen::Index i = 0; i < vectors.rows(); ++i)
        if (!std::isnan(pulled.conditions.prescribed[i])) {
            EXPECT_EQ(vectors.row(i).norm(), 0.0);
        }
}

TEST_P(FemRitzMotion, ConservesEnergyInAnySpaceWithoutDamping) {
    const auto body = swinging_beam();
    PulledBody pulled(body, GetParam(), constrained(*body));
    auto space = pulled.space();
    while (space.size() < 7)
        ASSERT_TRUE(space.extend());
    pulled.let_go(300, 1.0 / 60.0, 0.0);
    auto motion = fem_reference::motion_in(space, space.size(), *pulled.pulled.release);
    double largest_work = 0.0, largest_error = 0.0;
    for (int step = 0; step < 300; ++step) {
        motion.advance();
        const Eigen::VectorXd q = motion.displacement();
        const double work = space.force().dot(q);
        const double energy = 0.5 * motion.velocity().squaredNorm() + 0.5 * q.dot(space.stiffness() * q);
        largest_work = std::max(largest_work, std::abs(work));
        largest_error = std::max(largest_error, std::abs(energy - work));
    }
    EXPECT_GT(largest_work, 0.0);
    EXPECT_LT(largest_error, 1e-10 * largest_work);
}

TEST_P(FemRitzMotion, IsNoneWhereNothingWasPulled) {
    const auto body = swinging_beam();
    PulledBody pulled(body, GetParam(), constrained(*body));
    pulled.start.assign(pulled.start.size(), 0.0);
    auto space = pulled.space();
    EXPECT_FALSE(space.extend());
    const auto history = pulled.fast();
    EXPECT_EQ(history.displacement, std::vector<Vector3>(2 * history.time.size(), Vector3::Zero()));
    EXPECT_EQ(history.frames.size(), 51 * body->mesh.points.size());
    EXPECT_EQ(history.kinetic_energy, std::vector<double>(history.time.size(), 0.0));
    EXPECT_EQ(history.strain_energy, history.kinetic_energy);
}

TEST_P(FemRitzMotion, IsTheSameEveryTime) {
    const auto body = swinging_beam();
    const PulledBody pulled(body, GetParam(), constrained_elsewhere(*body));
    const auto first = pulled.fast(), second = pulled.fast();
    EXPECT_EQ(first.displacement, second.displacement);
    EXPECT_EQ(first.frames, second.frames);
    EXPECT_EQ(first.kinetic_energy, second.kinetic_energy);
    EXPECT_EQ(first.strain_energy, second.strain_energy);
}

INSTANTIATE_TEST_SUITE_P(Degree, FemRitzMotion, testing::Values(1, 2));

} // namespace livermark
