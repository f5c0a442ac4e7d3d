#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

#include "core/mesh/refinement.hpp"
#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/dynamics/relaxing_solver.hpp"
#include "fem_reference/dynamics/release.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/not_a_number.hpp"
#include "tests/samples/relaxing_cube.hpp"

namespace livermark {
namespace {

using core::Vector3;
using fem_reference::Formulation;
using fem_reference::RelaxingSolver;
using fem_reference::SolverChoice;
using fem_reference::StaticSolver;

constexpr double endless = std::numeric_limits<double>::infinity();

struct LinearElements {
    int degree;
    Formulation formulation;
};
constexpr std::array all_linear_elements{LinearElements{1, Formulation::displacement},
                                         LinearElements{2, Formulation::displacement},
                                         LinearElements{2, Formulation::mixed}};

core::Solution solve_relaxing(const core::Problem &problem, const LinearElements &elements, int steps_per_record = 8) {
    StaticSolver solver(problem.body, elements.degree, SolverChoice::automatic, elements.formulation);
    return RelaxingSolver(problem.body, solver, SolverChoice::automatic).solve(problem.load_case, steps_per_record);
}

/// 0 to 1 in a second, and then as it is.
core::SlowHistory ramp_and_hold(core::PronySeries relaxation) {
    core::SlowHistory history{.relaxation = std::move(relaxation), .times = {0.0}, .factors = {0.0}};
    for (const double time : {0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 4.0, 8.0, 30.0}) {
        history.times.push_back(time);
        history.factors.push_back(std::min(time, 1.0));
    }
    return history;
}

const tests::RelaxingBar relaxing_bar{.material = {1060.0, 5000.0, 0.4}, .modulus = 0.6, .time = 1.5};

/// A cube on rollers that is free to draw in.
core::Problem cube_on_rollers() {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 1, 1});
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "x_min", {0.0, tests::nan, tests::nan});
    tests::prescribe(load_case, mesh, "y_min", {tests::nan, 0.0, tests::nan});
    tests::prescribe(load_case, mesh, "z_min", {tests::nan, tests::nan, 0.0});
    load_case.slow_history =
        ramp_and_hold({.name = "one", .moduli = {relaxing_bar.modulus}, .times = {relaxing_bar.time}});
    return {tests::make_body(mesh, relaxing_bar.material), load_case};
}

double largest_stress_error(const core::Solution &solution, const core::SlowHistory &history) {
    double worst = 0.0;
    for (int k = 0; k < history.num_records(); ++k) {
        const double exact =
            relaxing_bar.stress(history.times[k], 1.0) * 0.01 * 0.01; // strain of 0.01, area of 0.01 m^2
        worst = std::max(worst, std::abs(solution.path[k].reaction.back().x() - exact));
    }
    return worst / (relaxing_bar.stress(1.0, 1.0) * 1e-4);
}

core::Problem stretched_cube() {
    auto problem = cube_on_rollers();
    tests::prescribe(problem.load_case, problem.body->mesh, "x_max", {0.001, tests::nan, tests::nan});
    return problem;
}

/// A rod under its weight and with a side that is moved; three regions of Poisson's ratios.
core::Problem heavy_rod(const std::array<double, 2> &poisson) {
    auto problem = tests::constrained_rod(tests::shaken_box_mesh(tests::rod_size, {2, 2, 2}), poisson,
                                          [](int t) { return t % 5 == 0; });
    problem.load_case.slow_history = ramp_and_hold({.name = "two", .moduli = {0.3, 0.4}, .times = {0.4, 7.0}});
    return problem;
}

core::Problem pressed_rod(const std::array<double, 2> &poisson) {
    auto problem = heavy_rod(poisson);
    auto pressed = tests::held(problem.body->mesh);
    tests::press(pressed, problem.body->mesh, "x_max", {-1.0, 0.2, 0.0}, 0.001);
    pressed.slow_history = problem.load_case.slow_history;
    return {problem.body, pressed};
}

core::Problem pulled_rod(const std::array<double, 2> &poisson) {
    auto problem = heavy_rod(poisson);
    auto pulled = tests::held(problem.body->mesh);
    tests::pull(pulled, problem.body->mesh, "x_max", {20.0, -10.0, 5.0});
    pulled.slow_history = problem.load_case.slow_history;
    return {problem.body, pulled};
}

/// The same body with shear moduli of a part of what they were.
std::shared_ptr<const core::Body> softened(const core::Body &body, double part) {
    auto soft = std::make_shared<core::Body>(body);
    for (auto &material : soft->materials) {
        const double bulk = material.lame_lambda() + 2.0 / 3.0 * material.shear_modulus();
        const double shear = part * material.shear_modulus();
        material.young_modulus = 9.0 * bulk * shear / (3.0 * bulk + shear);
        material.poisson_ratio = (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear));
    }
    return soft;
}

void expect_same_point(const core::PathPoint &point, const core::PathPoint &expected, double tolerance) {
    EXPECT_LE(tests::relative_l2(point.displacement, expected.displacement),
              std::max(tolerance, 1e-6)); // they are of single precision
    EXPECT_LT(tests::relative_difference(point.reaction, expected.reaction), tolerance);
    EXPECT_NEAR(point.strain_energy, expected.strain_energy, tolerance * expected.strain_energy);
}

} // namespace

TEST(RelaxingElements, StressOfAStretchedCubeFadesAsInClosedForm) {
    const auto problem = stretched_cube();
    for (const auto &elements : all_linear_elements) {
        const auto solution = solve_relaxing(problem, elements, 64);
        ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
        ASSERT_EQ(solution.path.size(), problem.load_case.slow_history->times.size());
        EXPECT_LT(largest_stress_error(solution, *problem.load_case.slow_history), 2e-6);
    }
}

TEST(RelaxingElements, HalfAStepIsAQuarterOfTheError) {
    const auto problem = stretched_cube();
    double before = 0.0;
    for (const int steps : {1, 2, 4, 8}) {
        const double error = largest_stress_error(solve_relaxing(problem, all_linear_elements[0], steps),
                                                  *problem.load_case.slow_history);
        if (before > 0.0) {
            EXPECT_GT(before / error, 3.6);
            EXPECT_LT(before / error, 4.4);
        }
        before = error;
    }
    EXPECT_LT(before, 1e-4);
}

TEST(RelaxingElements, ACubeUnderAForceCreepsAsInClosedForm) {
    auto problem = cube_on_rollers();
    tests::pull(problem.load_case, problem.body->mesh, "x_max", {40.0, 0.0, 0.0});
    const auto &mesh = problem.body->mesh;
    const auto &history = *problem.load_case.slow_history;
    for (const auto &elements : all_linear_elements) {
        const auto solution = solve_relaxing(problem, elements, 64);
        for (int k = 1; k < history.num_records(); ++k)
            for (int node = 0; node < mesh.num_nodes(); ++node) {
                const double exact = relaxing_bar.strain(history.times[k], 1.0) * 40.0 * mesh.points[node].x();
                EXPECT_NEAR(solution.path[k].displacement[node].x(), exact, 1e-5 * 8e-4) << history.times[k];
            }
    }
}

TEST(RelaxingElements, InfiniteAndZeroTimesAreTheTwoElasticBodies) {
    for (auto problem : {heavy_rod({0.45, 0.35}), pressed_rod({0.45, 0.35}), pulled_rod({0.45, 0.35})})
        for (const auto &elements : all_linear_elements)
            for (const double time : {endless, 0.0}) {
                auto &history = *problem.load_case.slow_history;
                history.relaxation.times = {time, time};
                const auto body = time > 0.0 ? problem.body : softened(*problem.body, 0.3);
                const auto elastic = fem_reference::solve_static({body, problem.load_case}, elements.degree,
                                                                 SolverChoice::automatic, elements.formulation);
                const auto solution = solve_relaxing(problem, elements, 1);
                ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
                for (int k = 1; k < history.num_records(); ++k) {
                    core::PathPoint expected;
                    const double factor = history.factors[k];
                    for (const auto &displacement : elastic.displacement)
                        expected.displacement.emplace_back((factor * displacement).cast<float>());
                    for (const auto &reaction : elastic.reaction)
                        expected.reaction.emplace_back(factor * reaction);
                    expected.strain_energy = factor * factor * elastic.strain_energy;
                    expect_same_point(solution.path[k], expected, 2e-6);
                    EXPECT_NEAR(solution.path[k].dissipated_energy, 0.0, 1e-12 * expected.strain_energy);
                }
                EXPECT_LT(tests::relative_difference(solution.displacement, elastic.displacement), 2e-6);
            }
}

/// The slow way: every unknown in every step, with dense matrices.
TEST(RelaxingElements, AgreesWithStepsOfAllUnknowns) {
    constexpr int steps_per_record = 4;
    for (const auto &problem : {heavy_rod({0.2, 0.45}), pulled_rod({0.2, 0.45})}) {
        const auto &history = *problem.load_case.slow_history;
        const auto system = fem_reference::assemble(*problem.body, 1);
        const auto soft = fem_reference::assemble(*softened(*problem.body, 0.5), 1);
        const Eigen::MatrixXd whole = tests::dense(compressed_rows(system.stiffness));
        const Eigen::MatrixXd deviatoric = 2.0 * (whole - tests::dense(compressed_rows(soft.stiffness)));
        const Eigen::MatrixXd volumetric = whole - deviatoric;
        const auto conditions = fem_reference::dof_conditions(problem.load_case, system);
        const Eigen::Map<const Eigen::VectorXd> load(conditions.load.data(), whole.rows());
        Eigen::VectorXd u = Eigen::VectorXd::Zero(whole.rows());
        std::vector<Eigen::VectorXd> memories(2, u);
        const auto solution = solve_relaxing(problem, all_linear_elements[0], steps_per_record);
        for (int n = 1; n < history.num_records(); ++n) {
            const auto branches =
                core::branch_steps(history.relaxation, (history.times[n] - history.times[n - 1]) / steps_per_record);
            Eigen::MatrixXd matrix = volumetric + core::instant_part(history.relaxation, branches) * deviatoric;
            for (int part = 1; part <= steps_per_record; ++part) {
                const double factor = std::lerp(history.factors[n - 1], history.factors[n], part / 4.0);
                Eigen::VectorXd remembered = Eigen::VectorXd::Zero(u.size());
                for (int k = 0; k < 2; ++k)
                    remembered += branches[k].fade * memories[k] - branches[k].gain * u;
                Eigen::MatrixXd constrained = matrix;
                Eigen::VectorXd right = factor * load - deviatoric * remembered;
                for (Eigen::Index dof = 0; dof < u.size(); ++dof)
                    if (!std::isnan(conditions.prescribed[dof])) {
                        constrained.row(dof).setZero();
                        constrained(dof, dof) = 1.0;
                        right[dof] = factor * conditions.prescribed[dof];
                    }
                const Eigen::VectorXd now = constrained.partialPivLu().solve(right);
                for (int k = 0; k < 2; ++k)
                    memories[k] = branches[k].fade * memories[k] + branches[k].gain * (now - u);
                u = now;
            }
            const auto &point = solution.path[n];
            for (std::size_t node = 0; node < point.displacement.size(); ++node)
                EXPECT_LT((point.displacement[node].cast<double>() - u.segment<3>(3 * static_cast<Eigen::Index>(node)))
                              .norm(),
                          1e-5 * u.cwiseAbs().maxCoeff());
        }
    }
}

TEST(RelaxingElements, WorkIsStoredOrDissipated) {
    for (const auto &problem : {heavy_rod({0.45, 0.2}), pressed_rod({0.45, 0.45}), pulled_rod({0.45, 0.45})})
        for (const auto &elements : all_linear_elements) {
            std::array<double, 2> gaps{};
            for (const int i : {0, 1}) {
                const auto solution = solve_relaxing(problem, elements, 16 << i);
                ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
                double dissipated = 0.0;
                for (const auto &point : solution.path) {
                    EXPECT_GE(point.dissipated_energy, dissipated);
                    dissipated = point.dissipated_energy;
                    gaps[i] = std::max(gaps[i], std::abs(point.work - point.strain_energy - point.dissipated_energy) /
                                                    solution.path.back().work);
                }
                EXPECT_GT(dissipated, 0.05 * solution.path.back().work);
            }
            EXPECT_LT(gaps[0], 2e-3);
            EXPECT_GT(gaps[0] / gaps[1], 3.0) << "the trapezoidal rule is of second order";
        }
}

TEST(RelaxingElements, ReactionsBalanceLoads) {
    const auto problem = pulled_rod({0.45, 0.35});
    const auto &history = *problem.load_case.slow_history;
    const Vector3 whole = Vector3(20.0, -10.0, 5.0) * tests::rod_size.y() * tests::rod_size.z();
    for (const auto &elements : all_linear_elements) {
        const auto solution = solve_relaxing(problem, elements);
        for (int k = 0; k < history.num_records(); ++k)
            EXPECT_LT((solution.path[k].reaction.front() + history.factors[k] * whole).norm(), 1e-5 * whole.norm());
    }
}

TEST(RelaxingElements, ARefinedBodyIsSolvedAsABodyOfItsOwn) {
    auto problem = pressed_rod({0.45, 0.45});
    StaticSolver solver(problem.body, 2, SolverChoice::automatic, Formulation::mixed);
    RelaxingSolver coarse(problem.body, solver, SolverChoice::automatic);
    const auto refined = core::refine_at_rims_and_tools(problem);
    constexpr double tolerance = 1e-8;
    StaticSolver fine_solver(refined.problem.body, solver, tolerance, refined.parent_tetrahedron);
    RelaxingSolver fine(refined.problem.body, fine_solver, SolverChoice::automatic, coarse, tolerance,
                        refined.parent_tetrahedron);
    const auto solution = fine.solve(refined.problem.load_case);
    const auto expected = solve_relaxing(refined.problem, all_linear_elements[2]);
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
    for (std::size_t k = 1; k < expected.path.size(); ++k)
        expect_same_point(solution.path[k], expected.path[k], 1e-5);
}

TEST(RelaxingElements, SayWhenTheBodyIsFree) {
    auto problem = pulled_rod({0.4, 0.4});
    auto free = tests::empty_load_case(problem.body->mesh);
    tests::pull(free, problem.body->mesh, "x_max", {20.0, -10.0, 5.0});
    free.slow_history = problem.load_case.slow_history;
    for (const auto &elements : all_linear_elements)
        EXPECT_EQ(solve_relaxing({problem.body, free}, elements).status, core::SolutionStatus::not_converged);
}

namespace {

using fem_reference::ElasticSystem;

/// A rod that is held at one end and pulled at the other for a while, and then let go.
core::Problem pulled_rod(const core::PronySeries &series, double hold) {
    const auto mesh = tests::shaken_box_mesh({0.06, 0.03, 0.03}, {1, 1, 1});
    auto load_case = tests::held(mesh);
    tests::pull(load_case, mesh, "x_max", {20.0, -10.0, 5.0});
    load_case.slow_history =
        core::SlowHistory{.relaxation = series, .times = {0.0, 0.5, 1.0, 1.0 + hold}, .factors = {0.0, 0.5, 1.0, 1.0}};
    load_case.release = core::Release{.num_steps = 80,
                                      .output_interval = 0.002,
                                      .damping = {2.0, 1e-4},
                                      .probes = {{"end", static_cast<int>(mesh.points.size()) - 1}}};
    return {tests::make_body(mesh, {1060.0, 5e3, 0.45}), load_case};
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
    const Eigen::MatrixXd whole = tests::dense(compressed_rows(system.stiffness));
    const Eigen::MatrixXd shear_part =
        tests::dense(compressed_rows(fem_reference::assemble(without_lambda, degree).stiffness));
    DenseParts parts;
    parts.volumetric = (lambda + 2.0 / 3.0 * mu) / lambda * (whole - shear_part);
    parts.deviatoric = whole - parts.volumetric;
    const auto mass = tests::dense(fem_reference::consistent_mass(body, system));
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
            return tests::relative_l2(
                fem_reference::release_relaxed(*problem.body, system, stiffness, problem.load_case, start, steps)
                    .displacement,
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
        EXPECT_LT(tests::relative_l2(solution.history.value().displacement, expected.displacement), 2e-4) << degree;
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
