#include "fem_reference/dynamics/relaxed_motion.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <memory>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/dynamics/relaxing_solver.hpp"
#include "fem_reference/dynamics/release.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"

namespace livermark {
namespace {

using core::Vector3;
using fem_reference::ElasticSystem;
using fem_reference::Formulation;
using fem_reference::RelaxingSolver;
using fem_reference::SolverChoice;
using fem_reference::StaticSolver;

/// A rod that is held at one end and pulled at the other for a while, and then let go.
core::Problem pulled_rod(const core::PronySeries &series, double hold) {
    const auto mesh = tests::shaken_box_mesh({0.06, 0.03, 0.03}, {1, 1, 1});
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "x_min", Vector3::Zero());
    tests::pull(load_case, mesh, "x_max", {20.0, -10.0, 5.0});
    load_case.slow_history =
        core::SlowHistory{.relaxation = series, .times = {0.0, 0.5, 1.0, 1.0 + hold}, .factors = {0.0, 0.5, 1.0, 1.0}};
    load_case.release = core::Release{.num_steps = 80,
                                      .output_interval = 0.002,
                                      .damping = {2.0, 1e-4},
                                      .probes = {{"end", static_cast<int>(mesh.points.size()) - 1}}};
    return {tests::make_body(mesh, {1060.0, 5e3, 0.45}), load_case};
}

Eigen::MatrixXd dense(const fem_reference::SymmetricMatrix &matrix) {
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(matrix.num_rows(), matrix.num_rows());
    for (int row = 0; row < matrix.num_rows(); ++row)
        for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k)
            all(row, matrix.column[k]) = matrix.value[k];
    return all;
}

/// The stiffness that the shear modulus alone makes, and with what lambda adds the volumetric part.
struct DenseParts {
    Eigen::MatrixXd volumetric, deviatoric, mass;
};

DenseParts dense_parts(const core::Body &body, int degree) {
    const auto &material = body.materials.front();
    const double mu = material.shear_modulus(), lambda = material.lame_lambda();
    auto without_lambda = body;
    without_lambda.materials.front() = {material.density, 2.0 * mu, 0.0};
    const auto system = fem_reference::assemble(body, degree);
    const Eigen::MatrixXd whole = dense(compressed_rows(system.stiffness));
    const Eigen::MatrixXd of_mu = dense(compressed_rows(fem_reference::assemble(without_lambda, degree).stiffness));
    DenseParts parts;
    parts.volumetric = (lambda + 2.0 / 3.0 * mu) / lambda * (whole - of_mu);
    parts.deviatoric = whole - parts.volumetric;
    const auto mass = dense(fem_reference::consistent_mass(body, system));
    parts.mass = Eigen::MatrixXd::Zero(whole.rows(), whole.cols());
    for (Eigen::Index a = 0; a < mass.rows(); ++a)
        for (Eigen::Index b = 0; b < mass.cols(); ++b)
            parts.mass.block<3, 3>(3 * a, 3 * b) = mass(a, b) * Eigen::Matrix3d::Identity();
    return parts;
}

/// Solutions of (u, v, w_k)' = A (u, v, w_k) at the records, from rest.
std::vector<Vector3> exact_motion(const core::Problem &problem, int degree, const fem_reference::RelaxedState &start) {
    const auto parts = dense_parts(*problem.body, degree);
    const auto system = fem_reference::assemble(*problem.body, degree);
    const auto &load_case = problem.load_case;
    const auto &series = load_case.slow_history->relaxation;
    const auto &release = *load_case.release;
    const auto conditions = fem_reference::dof_conditions(core::without_tractions(load_case), system);
    std::vector<Eigen::Index> free;
    for (std::size_t i = 0; i < conditions.prescribed.size(); ++i)
        if (std::isnan(conditions.prescribed[i]))
            free.push_back(static_cast<Eigen::Index>(i));
    const auto n = static_cast<Eigen::Index>(free.size()), b = static_cast<Eigen::Index>(series.moduli.size());
    const Eigen::MatrixXd inverse_mass = parts.mass(free, free).inverse();
    const Eigen::MatrixXd v = parts.volumetric(free, free), d = parts.deviatoric(free, free);
    const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(n, n);
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero((2 + b) * n, (2 + b) * n);
    Eigen::VectorXd at = Eigen::VectorXd::Zero((2 + b) * n);
    const auto part = [&](const std::vector<double> &values) {
        Eigen::VectorXd of(n);
        for (Eigen::Index i = 0; i < n; ++i)
            of[i] = values[static_cast<std::size_t>(free[static_cast<std::size_t>(i)])];
        return of;
    };
    at.head(n) = part(start.displacement);
    matrix.block(0, n, n, n) = one;
    matrix.block(n, 0, n, n) = -inverse_mass * (v + series.remaining() * d);
    matrix.block(n, n, n, n) = -release.damping.alpha * one - release.damping.beta * inverse_mass * (v + d);
    for (Eigen::Index k = 0; k < b; ++k) {
        at.segment((2 + k) * n, n) = part(start.branches[static_cast<std::size_t>(k)]);
        matrix.block(n, (2 + k) * n, n, n) = -inverse_mass * d;
        matrix.block((2 + k) * n, n, n, n) = series.moduli[static_cast<std::size_t>(k)] * one;
        matrix.block((2 + k) * n, (2 + k) * n, n, n) = -1.0 / series.times[static_cast<std::size_t>(k)] * one;
    }
    const Eigen::MatrixXd step = (release.output_interval * matrix).exp();
    const int probe = system.mesh_node[release.probes.front().node];
    std::vector<Vector3> motion;
    for (int record = 0; record <= release.num_steps; ++record, at = step * at) {
        Eigen::VectorXd all = Eigen::VectorXd::Zero(parts.mass.rows());
        all(free) = at.head(n);
        motion.emplace_back(all.segment<3>(3 * probe));
    }
    return motion;
}

double error_of(const core::History &history, const std::vector<Vector3> &expected) {
    double difference = 0.0, size = 0.0;
    for (std::size_t k = 0; k < expected.size(); ++k) {
        difference += (history.displacement[k] - expected[k]).squaredNorm();
        size += expected[k].squaredNorm();
    }
    return std::sqrt(difference / size);
}

const core::PronySeries two_branches{"two", {0.3, 0.3}, {0.01, 0.3}};

/// A state that loads have left, with branches of another shape.
fem_reference::RelaxedState some_state(const ElasticSystem &system) {
    fem_reference::RelaxedState state;
    state.displacement.assign(3 * system.points.size(), 0.0);
    state.branches.assign(2, state.displacement);
    for (std::size_t i = 0; i < system.points.size(); ++i) {
        const double x = system.points[i].x();
        state.displacement[3 * i + 1] = 0.1 * x * x;
        state.branches[0][3 * i] = 0.02 * x;
        state.branches[1][3 * i + 2] = -0.1 * x * x;
    }
    return state;
}

TEST(RelaxedMotion, IsThatOfTheMatrixExponentialAndOfSecondOrder) {
    for (const int degree : {1, 2}) {
        const auto problem = pulled_rod(two_branches, 1.0);
        const auto system = fem_reference::assemble(*problem.body, degree);
        const auto &material = problem.body->materials.front();
        const double mu = material.shear_modulus(), bulk = 2.0 * (material.lame_lambda() + 2.0 / 3.0 * mu);
        auto other = *problem.body;
        other.materials.front() = {material.density, 9.0 * bulk * mu / (3.0 * bulk + mu),
                                   (3.0 * bulk - 2.0 * mu) / (2.0 * (3.0 * bulk + mu))};
        const auto with_bulk = fem_reference::assemble(other, degree);
        const fem_reference::SplitStiffness stiffness(system.stiffness, with_bulk.stiffness, 0.5);
        const auto start = some_state(system);
        const auto expected = exact_motion(problem, degree, start);
        const auto error = [&](int steps) {
            return error_of(
                fem_reference::release_relaxed(*problem.body, system, stiffness, problem.load_case, start, steps),
                expected);
        };
        const double coarse = error(8), fine = error(16);
        EXPECT_LT(fine, 1e-3) << degree;
        EXPECT_NEAR(coarse / fine, 4.0, 0.2) << degree;
    }
}

core::Solution solve(const core::Problem &problem, int degree) {
    StaticSolver solver(problem.body, degree, SolverChoice::automatic, Formulation::displacement);
    return RelaxingSolver(problem.body, solver, SolverChoice::automatic).solve(problem.load_case);
}

TEST(RelaxedMotion, BeginsWhereTheHistoryEndsAndLosesEnergy) {
    for (const int degree : {1, 2}) {
        const auto problem = pulled_rod(two_branches, 0.2);
        const auto solution = solve(problem, degree);
        ASSERT_TRUE(solution.history);
        const auto &history = *solution.history;
        const auto probe = static_cast<std::size_t>(problem.load_case.release->probes.front().node);
        EXPECT_LT((history.displacement.front() - solution.displacement[probe]).norm(),
                  1e-12 * solution.displacement[probe].norm());
        EXPECT_NEAR(history.strain_energy.front(), solution.strain_energy, 1e-9 * solution.strain_energy);
        EXPECT_EQ(history.kinetic_energy.front(), 0.0);
        for (std::size_t k = 1; k < history.time.size(); ++k)
            ASSERT_LT(history.kinetic_energy[k] + history.strain_energy[k],
                      (1.0 + 1e-9) * (history.kinetic_energy[k - 1] + history.strain_energy[k - 1]))
                << k;
        EXPECT_LT(history.kinetic_energy.back() + history.strain_energy.back(), 0.9 * history.strain_energy.front());
    }
}

TEST(RelaxedMotion, IsTheElasticOneWithEndlessTimes) {
    const auto problem = pulled_rod({"endless", {0.5}, {1e15}}, 1.0);
    for (const int degree : {1, 2}) {
        const auto solution = solve(problem, degree);
        auto elastic = problem.load_case;
        elastic.slow_history.reset();
        const auto system = fem_reference::assemble(*problem.body, degree);
        StaticSolver solver(problem.body, degree, SolverChoice::automatic, Formulation::displacement);
        const auto expected = solver.solve(elastic).history.value();
        EXPECT_LT(error_of(solution.history.value(), expected.displacement), 2e-4) << degree;
    }
}

TEST(RelaxedMotion, IsNotThatOfMixedElements) {
    const auto problem = pulled_rod(two_branches, 0.2);
    StaticSolver solver(problem.body, 2, SolverChoice::automatic, Formulation::mixed);
    const auto solution = RelaxingSolver(problem.body, solver, SolverChoice::automatic).solve(problem.load_case);
    EXPECT_EQ(solution.status, core::SolutionStatus::ok);
    EXPECT_FALSE(solution.history);
}

} // namespace
} // namespace livermark
