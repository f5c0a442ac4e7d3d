#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "fem_reference/hyperelastic/relaxation/slow_path.hpp"
#include "fem_reference/relaxation/relaxing_solver.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/not_a_number.hpp"

namespace livermark {
namespace {

using core::Vector3;
using fem_reference::Formulation;
using hyperelastic::Matrix3;

constexpr double newton_tolerance = 1e-10;

Matrix3 random_matrix(std::mt19937 &generator, double size) {
    std::uniform_real_distribution<double> number(-size, size);
    Matrix3 matrix;
    for (double &entry : matrix.reshaped())
        entry = number(generator);
    return matrix;
}

/// A cube on rollers that is stretched in a second, and held.
core::Problem cube_held_stretched(double strain) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {1, 1, 1});
    auto load_case = tests::empty_load_case(mesh);
    load_case.regime = core::Regime::large;
    tests::prescribe(load_case, mesh, "x_min", {0.0, tests::nan, tests::nan});
    tests::prescribe(load_case, mesh, "y_min", {tests::nan, 0.0, tests::nan});
    tests::prescribe(load_case, mesh, "z_min", {tests::nan, tests::nan, 0.0});
    tests::prescribe(load_case, mesh, "x_max", {0.1 * strain, tests::nan, tests::nan});
    load_case.slow_history = {.relaxation = {.name = "two", .moduli = {0.3, 0.4}, .times = {0.4, 7.0}},
                              .times = {0.0, 0.25, 0.5, 0.75, 1.0, 2.0, 4.0, 8.0, 30.0},
                              .factors = {0.0, 0.25, 0.5, 0.75, 1.0, 1.0, 1.0, 1.0, 1.0}};
    return {tests::make_body(mesh, {1060.0, 5000.0, 0.45}), load_case};
}

core::Solution solve_slowly(const core::Problem &problem, const hyperelastic::Discretisation &discretisation) {
    return hyperelastic::solve_history(problem, hyperelastic::material_law("neo_hookean"), discretisation,
                                       newton_tolerance);
}

const std::array<hyperelastic::Discretisation, 3> relaxing_elements{
    {{.degree = 1}, {.degree = 2}, {.degree = 2, .formulation = Formulation::mixed}}};

} // namespace

TEST(IsochoricPart, HasTheDerivativesOfItsEnergy) {
    const core::Material material{1060.0, 5000.0, 0.45};
    std::mt19937 generator(7);
    for (const auto &law : hyperelastic::all_materials()) {
        const Matrix3 f = Matrix3::Identity() + random_matrix(generator, 0.25);
        const Matrix3 half = random_matrix(generator, 900.0);
        const Matrix3 remembered = half + half.transpose();
        const hyperelastic::IsochoricPart part{law, material, 0.6, remembered};
        const auto stress = part.stress(f);
        const auto tangent = part.tangent(f);
        constexpr double step = 1e-6;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                Matrix3 more = f, less = f;
                more(i, j) += step;
                less(i, j) -= step;
                EXPECT_NEAR((part.energy(more) - part.energy(less)) / (2.0 * step), stress(i, j), 1e-4) << law.name;
                const Matrix3 slope = (part.stress(more) - part.stress(less)) / (2.0 * step);
                for (int k = 0; k < 3; ++k)
                    for (int l = 0; l < 3; ++l)
                        EXPECT_NEAR(slope(k, l), tangent(3 * k + l, 3 * i + j), 1e-3) << law.name;
            }
        EXPECT_NEAR(stress.cwiseProduct(f).sum(), 0.0, 1e-9) << "no pressure is in it";
    }
}

/// What one step of a branch without time adds is what the law loses.
TEST(IsochoricPart, IsWhatTheBranchesFollow) {
    const core::Material material{1060.0, 5000.0, 0.45};
    std::mt19937 generator(8);
    const auto &law = hyperelastic::material_law("neo_hookean");
    const Matrix3 f = Matrix3::Identity() + random_matrix(generator, 0.25);
    const Matrix3 followed = hyperelastic::isochoric_stress(law, material, f), nothing = Matrix3::Zero();
    const hyperelastic::IsochoricPart remembers{law, material, 0.0, followed}, loses{law, material, 1.0, nothing};
    EXPECT_LT((remembers.stress(f) + loses.stress(f)).norm(), 1e-9);
    const Matrix3 small = 1e-6 * (random_matrix(generator, 1.0));
    const Matrix3 strain = 0.5 * (small + small.transpose());
    const Matrix3 deviator = strain - strain.trace() / 3.0 * Matrix3::Identity();
    EXPECT_LT((hyperelastic::isochoric_stress(law, material, Matrix3::Identity() + small) -
               2.0 * material.shear_modulus() * deviator)
                  .norm(),
              1e-5 * 2.0 * material.shear_modulus() * deviator.norm());
}

TEST(RelaxingHyperelasticity, IsLinearAtSmallStrains) {
    constexpr double strain = 1e-5;
    const auto problem = cube_held_stretched(strain);
    fem_reference::StaticSolver solver(problem.body, 2);
    const auto linear = fem_reference::RelaxingSolver(problem.body, solver, fem_reference::SolverChoice::automatic)
                            .solve(problem.load_case, 1);
    for (const auto &elements : relaxing_elements) {
        const auto solution = solve_slowly(problem, elements);
        ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
        ASSERT_EQ(solution.path.size(), linear.path.size());
        for (std::size_t k = 1; k < linear.path.size(); ++k) {
            const double expected = linear.path[k].reaction.back().x();
            EXPECT_NEAR(solution.path[k].reaction.back().x(), expected, 20.0 * strain * expected);
            EXPECT_NEAR(solution.path[k].work, linear.path[k].work, 20.0 * strain * linear.path[k].work);
            EXPECT_NEAR(solution.path[k].strain_energy, linear.path[k].strain_energy,
                        20.0 * strain * linear.path[k].strain_energy);
            EXPECT_NEAR(solution.path[k].dissipated_energy, linear.path[k].dissipated_energy,
                        20.0 * strain * linear.path[k].strain_energy);
        }
    }
}

TEST(RelaxingHyperelasticity, InfiniteTimesAreTheElasticBody) {
    auto problem = cube_held_stretched(0.3);
    problem.load_case.slow_history->relaxation.times = {std::numeric_limits<double>::infinity(),
                                                        std::numeric_limits<double>::infinity()};
    for (const auto &elements : relaxing_elements) {
        const auto elastic = hyperelastic::solve(problem, hyperelastic::material_law("neo_hookean"), elements,
                                                 {.fractions = {0.25, 0.5, 0.75, 1.0}, .tolerance = newton_tolerance});
        const auto solution = solve_slowly(problem, elements);
        ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
        for (std::size_t k = 1; k < solution.path.size(); ++k)
            EXPECT_LT(tests::relative_difference(solution.path[k].reaction,
                                                 elastic.points[std::min<std::size_t>(k, 4) - 1].reaction),
                      1e-7);
        EXPECT_LT(tests::relative_difference(solution.displacement, elastic.solution.displacement), 1e-7);
    }
}

/// All nodes are held in a large deformation, so that what is remembered fades as exp(-t / tau).
TEST(RelaxingHyperelasticity, FadesExponentiallyInAHeldShape) {
    auto problem = cube_held_stretched(0.0);
    const auto &mesh = problem.body->mesh;
    problem.load_case = tests::empty_load_case(mesh);
    for (const auto *side : {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"})
        tests::prescribe(problem.load_case, mesh, side, Vector3::Zero());
    Matrix3 gradient;
    gradient << 0.3, 0.2, 0.0, 0.0, -0.1, 0.1, 0.0, 0.0, 0.05;
    for (const auto &point : mesh.points)
        problem.load_case.node_shift.emplace_back(gradient * point);
    problem.load_case.regime = core::Regime::large;
    constexpr double tau = 3.0;
    problem.load_case.slow_history = {.relaxation = {.name = "one", .moduli = {0.7}, .times = {tau}},
                                      .times = {0.0, 0.5, 1.0, 3.0, 5.0, 7.0},
                                      .factors = {0.0, 0.5, 1.0, 1.0, 1.0, 1.0}};
    const auto solution = solve_slowly(problem, relaxing_elements[1]);
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
    const auto force = [&](std::size_t k) { return solution.path[k].reaction[1]; };
    for (std::size_t k = 2; k < 4; ++k) {
        const Vector3 first = force(k) - force(k + 1), next = force(k + 1) - force(k + 2);
        EXPECT_LT((next - std::exp(-2.0 / tau) * first).norm(), 1e-8 * first.norm());
        EXPECT_GT(first.norm(), 0.01 * force(k).norm());
    }
}

} // namespace livermark
