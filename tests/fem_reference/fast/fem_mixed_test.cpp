#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "core/mesh/refinement.hpp"
#include "fem_reference/linear/chosen_solver.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/not_a_number.hpp"

namespace livermark {
namespace {

using core::Vector3;
using fem_reference::Formulation;
using fem_reference::SolverChoice;
using tests::nan;

/// A rod whose right half is stiffer, constrained at one end, with a side that is moved; pulled and hanging.
core::Problem rod(double left_poisson_ratio, double right_poisson_ratio, const std::array<int, 3> &bricks) {
    const auto mesh = tests::box_mesh(tests::rod_size, bricks);
    const auto is_right = [&](int t) {
        double x = 0.0;
        for (const int node : mesh.tetrahedra[t])
            x += 0.25 * mesh.points[node].x();
        return x > 0.5 * tests::rod_size.x();
    };
    auto problem = tests::constrained_rod(mesh, {left_poisson_ratio, right_poisson_ratio}, is_right);
    tests::pull(problem.load_case, problem.body->mesh, "x_max", {20.0, -10.0, 5.0});
    return problem;
}

void expect_agreement(const core::Solution &a, const core::Solution &b, double tolerance) {
    ASSERT_EQ(a.status, core::SolutionStatus::ok) << a.message;
    ASSERT_EQ(b.status, core::SolutionStatus::ok) << b.message;
    EXPECT_LT(tests::relative_difference(a.displacement, b.displacement), tolerance);
    EXPECT_LT(tests::relative_difference(a.reaction, b.reaction), tolerance);
    EXPECT_NEAR(a.strain_energy, b.strain_energy, tolerance * b.strain_energy);
}

} // namespace

/// The divergence of a quadratic field is linear, and then D u = C (lambda div u) without any error.
TEST(PressureSystem, KnowsTheDivergenceOfQuadraticFields) {
    const core::Material material{1060.0, 5000.0, 0.45};
    const auto mesh = tests::shaken_box_mesh({0.1, 0.08, 0.06}, {3, 2, 2});
    const auto body = tests::make_body(mesh, material);
    const auto system = fem_reference::assemble(*body, 2);
    const auto pressure = fem_reference::assemble_pressure(*body, system);
    ASSERT_EQ(pressure.num_pressures(), mesh.num_nodes());
    Eigen::VectorXd u(3 * system.num_nodes());
    for (int a = 0; a < system.num_nodes(); ++a) {
        const auto &x = system.points[a];
        u.segment<3>(3 * a) << x.x() * x.x(), x.x() * x.y() + x.z(), x.z() * x.z() - x.y() * x.x();
    }
    Eigen::VectorXd p(pressure.num_pressures()); // in the order of the nodes
    for (int node = 0; node < mesh.num_nodes(); ++node) {
        const auto &x = mesh.points[node];
        p[node] = material.lame_lambda() * (2.0 * x.x() + x.x() + 2.0 * x.z());
    }
    const Eigen::VectorXd left = tests::dense(pressure.divergence, u.size()) * u;
    const Eigen::VectorXd right = tests::dense(pressure.compliance) * p;
    EXPECT_LT((left - right).norm(), 1e-13 * right.norm());
}

TEST(FemMixed, IsTheDisplacementFormulationWhereNothingIsNearlyIncompressible) {
    const auto problem = rod(0.25, 0.3, {4, 3, 3});
    expect_agreement(fem_reference::solve_static(problem, 2, SolverChoice::direct, Formulation::mixed),
                     fem_reference::solve_static(problem, 2), 1e-15);
}

/// Two regions with a pressure each, or one of them without.
TEST(FemMixed, AgreesWithADenseSolve) {
    for (const double right_poisson_ratio : {0.499, 0.2}) {
        const auto problem = rod(0.45, right_poisson_ratio, {2, 2, 1});
        const auto &body = *problem.body;
        const auto system = fem_reference::assemble(fem_reference::without_pressure(body), 2);
        const auto pressure = fem_reference::assemble_pressure(body, system);
        const Eigen::Index num_u = 3 * system.num_nodes(), num_p = pressure.num_pressures();
        Eigen::MatrixXd matrix(num_u + num_p, num_u + num_p);
        matrix.topLeftCorner(num_u, num_u) = tests::dense(compressed_rows(system.stiffness));
        matrix.bottomLeftCorner(num_p, num_u) = tests::dense(pressure.divergence, num_u);
        matrix.topRightCorner(num_u, num_p) = matrix.bottomLeftCorner(num_p, num_u).transpose();
        matrix.bottomRightCorner(num_p, num_p) = -tests::dense(pressure.compliance);
        Eigen::VectorXd right_hand_side = Eigen::VectorXd::Zero(num_u + num_p);
        for (int a = 0; a < system.num_nodes(); ++a)
            right_hand_side.segment<3>(3 * a) = system.mass_integral[a] * problem.load_case.acceleration;
        const auto num_local = system.nodes_per_facet;
        for (std::size_t k = 0; k < system.facet_nodes.size(); ++k)
            if (problem.load_case.is_loaded(k / num_local))
                right_hand_side.segment<3>(3 * system.facet_nodes[k]) +=
                    system.facet_integral[k] * problem.load_case.value[k / num_local];
        const auto prescribe = [&](Eigen::Index row, double value) {
            matrix.row(row).setZero();
            matrix(row, row) = 1.0;
            right_hand_side[row] = value;
        };
        for (int a = 0; a < system.num_nodes(); ++a) {
            if (std::abs(system.points[a].y()) < 1e-12)
                prescribe(3 * a + 1, 0.001);
            for (int i = 0; i < 3; ++i)
                if (std::abs(system.points[a].x()) < 1e-12)
                    prescribe(3 * a + i, 0.0);
        }
        const Eigen::VectorXd exact = matrix.partialPivLu().solve(right_hand_side);
        const auto found = fem_reference::solve_static(problem, 2, SolverChoice::direct, Formulation::mixed);
        ASSERT_EQ(found.status, core::SolutionStatus::ok) << found.message;
        std::vector<Vector3> expected;
        for (int a = 0; a < body.mesh.num_nodes(); ++a)
            expected.emplace_back(exact.segment<3>(3 * a));
        EXPECT_LT(tests::relative_difference(found.displacement, expected), 1e-8) << right_poisson_ratio;
        EXPECT_EQ(found.degrees_of_freedom, num_u + num_p);
    }
}

TEST(FemMixed, SolversAgree) {
    const auto problem = rod(0.45, 0.499, {3, 2, 2});
    const auto direct = fem_reference::solve_static(problem, 2, SolverChoice::direct, Formulation::mixed);
    expect_agreement(fem_reference::solve_static(problem, 2, SolverChoice::iterative, Formulation::mixed), direct,
                     1e-7);

    const auto over_corners = fem_reference::solve_static(problem, 2, SolverChoice::automatic, Formulation::mixed);
    EXPECT_NE(over_corners.solver.find("two levels over CHOLMOD"), std::string::npos) << over_corners.solver;
    expect_agreement(over_corners, direct, 1e-7);

    const auto fine = core::refine(problem);
    fem_reference::StaticSolver coarse(problem.body, 2, SolverChoice::direct, Formulation::mixed);
    fem_reference::StaticSolver two_levels(fine.body, coarse);
    const auto found = two_levels.solve(fine.load_case);
    EXPECT_NE(found.solver.find("two levels over CHOLMOD"), std::string::npos) << found.solver;
    const auto exact = fem_reference::solve_static(fine, 2, SolverChoice::direct, Formulation::mixed);
    expect_agreement(found, exact, 1e-7);

    fem_reference::StaticSolver above_corners(problem.body, 2, SolverChoice::automatic, Formulation::mixed);
    fem_reference::StaticSolver three_levels(fine.body, above_corners);
    expect_agreement(three_levels.solve(fine.load_case), exact, 1e-7);

    constexpr double tolerance = 1e-5;
    fem_reference::StaticSolver in_haste(fine.body, above_corners, tolerance);
    expect_agreement(in_haste.solve(fine.load_case), exact, tolerance);
}

TEST(FemMixed, MultigridOnTheCornersServesTheRefinedMesh) {
    constexpr int no_factor = 0;
    const auto problem = rod(0.45, 0.499, {3, 2, 2});
    const auto fine = core::refine(problem);
    fem_reference::StaticSolver coarse(problem.body, 2, SolverChoice::automatic, Formulation::mixed, no_factor);
    fem_reference::StaticSolver solver(fine.body, coarse);
    const auto found = solver.solve(fine.load_case);
    EXPECT_NE(found.solver.find("two levels over two levels over ML"), std::string::npos) << found.solver;
    expect_agreement(found, fem_reference::solve_static(fine, 2, SolverChoice::direct, Formulation::mixed), 1e-7);
}

/// As on a very large body: there are more corners than ML solves for exactly. It has to notice when other components
/// are constrained.
TEST(FemMixed, MultigridOnTheCornersTakesOneLoadCaseAfterTheOther) {
    constexpr int no_factor = 0;
    const auto problem = rod(0.45, 0.49, {12, 8, 7});
    auto other = tests::held(problem.body->mesh, "z_min");
    tests::pull(other, problem.body->mesh, "x_max", {0.0, 3.0, 1.0});
    fem_reference::StaticSolver solver(problem.body, 2, SolverChoice::automatic, Formulation::mixed, no_factor);
    fem_reference::StaticSolver factored(problem.body, 2, SolverChoice::automatic, Formulation::mixed);
    EXPECT_EQ(solver.max_columns(), 1u);
    ASSERT_GT(3 * problem.body->mesh.num_nodes(), 2000);
    for (const auto &load_case : {problem.load_case, other, problem.load_case}) {
        const auto found = solver.solve(load_case);
        EXPECT_NE(found.solver.find("two levels over ML"), std::string::npos) << found.solver;
        expect_agreement(found, factored.solve(load_case), 1e-7);
    }
}

/// load cases that constrain different components, and one that leaves the body free to move.
class FemTogether : public testing::Test {
  protected:
    FemTogether() {
        auto hanging = problem.load_case;
        hanging.acceleration = {0.0, 0.0, -0.5};
        auto turned = tests::held(mesh, "z_min");
        tests::pull(turned, mesh, "x_max", {0.0, 3.0, 1.0});
        auto unloaded = turned;
        std::ranges::fill(unloaded.value, Vector3::Zero());
        load_cases = {problem.load_case, hanging, turned, unloaded};
        for (int i = 0; i < 6; ++i) { // more than are solved at once
            load_cases.push_back(turned);
            load_cases.back().acceleration[i % 3] = 1.0 + i;
        }
    }

    static void expect_same(const core::Solution &a, const core::Solution &b, double tolerance) {
        ASSERT_EQ(a.status, b.status);
        if (b.strain_energy > 0.0)
            expect_agreement(a, b, tolerance);
        else
            EXPECT_EQ(a.displacement, b.displacement);
    }

    core::Problem problem = rod(0.45, 0.49, {3, 2, 2});
    const core::TetraMesh &mesh = problem.body->mesh;
    std::vector<core::LoadCase> load_cases;
};

TEST_F(FemTogether, SolutionsAreThoseOfOneByOne) {
    fem_reference::StaticSolver solver(problem.body, 2, SolverChoice::automatic, Formulation::mixed);
    ASSERT_EQ(solver.max_columns(), 8u);
    const auto together = solver.solve(std::span(load_cases));
    ASSERT_EQ(together.size(), load_cases.size());
    for (std::size_t c = 0; c < load_cases.size(); ++c) {
        SCOPED_TRACE(c);
        expect_same(together[c], solver.solve(load_cases[c]), 1e-8);
    }
    EXPECT_NE(together.front().solver.find("8 load cases together"), std::string::npos) << together.front().solver;
    EXPECT_NE(together.back().solver.find("2 load cases together"), std::string::npos) << together.back().solver;
}

TEST_F(FemTogether, SolutionsOnTheRefinedMeshAreThoseOfOneByOne) {
    const auto refined = std::make_shared<const core::Body>(core::refine(*problem.body));
    fem_reference::StaticSolver coarse(problem.body, 2, SolverChoice::automatic, Formulation::mixed);
    fem_reference::StaticSolver fine(refined, coarse, 1e-9);
    std::vector<core::LoadCase> some;
    for (std::size_t c = 0; c < 3; ++c)
        some.push_back(core::refine(load_cases[c], problem.body->mesh));
    const auto together = fine.solve(std::span(some));
    coarse.solve(std::span(load_cases)); // what it holds then must not disturb the fine one
    for (std::size_t c = 0; c < some.size(); ++c) {
        SCOPED_TRACE(c);
        expect_same(together[c], fine.solve(some[c]), 1e-8);
    }
}

TEST_F(FemTogether, OneThatIsFreeToMoveLeavesTheOthersTheirSolutions) {
    auto floating = tests::empty_load_case(mesh);
    tests::prescribe(floating, mesh, "x_min", {0.0, 0.0, nan});
    floating.acceleration = {0.0, 0.0, 1.0};
    load_cases.resize(2);
    load_cases.insert(load_cases.begin(), floating);
    fem_reference::StaticSolver solver(problem.body, 2, SolverChoice::automatic, Formulation::mixed);
    const auto together = solver.solve(std::span(load_cases));
    ASSERT_EQ(together.size(), 3u);
    EXPECT_EQ(together[0].status, core::SolutionStatus::not_converged);
    EXPECT_NE(together[0].message.find("free to move"), std::string::npos);
    for (std::size_t c = 1; c < 3; ++c)
        expect_same(together[c], solver.solve(load_cases[c]), 1e-8);
}

TEST_F(FemTogether, DirectSolversTakeOneByOne) {
    fem_reference::StaticSolver solver(problem.body, 2, SolverChoice::direct, Formulation::mixed);
    EXPECT_EQ(solver.max_columns(), 1u);
    const auto found = solver.solve(std::span(load_cases).first(2));
    for (std::size_t c = 0; c < 2; ++c)
        expect_same(found[c], solver.solve(load_cases[c]), 1e-15);
}

/// The solution is the same, as tested above: the tolerance is in parts of the whole load, wherever iterations
/// begin.
TEST(FemNestedIteration, TakesFewerIterations) {
    const auto problem = rod(0.45, 0.45, {6, 4, 4});
    const core::Body fine_body = core::refine(*problem.body);
    const auto fine_load_case = core::refine(problem.load_case, problem.body->mesh);
    const auto num_iterations = [&](bool is_nested) {
        const auto coarse = fem_reference::assemble(fem_reference::without_pressure(*problem.body), 2);
        const auto fine = fem_reference::assemble(fem_reference::without_pressure(fine_body), 2);
        const auto coarse_pressure = fem_reference::assemble_pressure(*problem.body, coarse),
                   fine_pressure = fem_reference::assemble_pressure(fine_body, fine);
        fem_reference::ChosenSolver coarse_solver(coarse, SolverChoice::direct);
        fem_reference::ChosenSolver fine_solver(fine, coarse, coarse_solver);
        fem_reference::MixedSolver mixed_coarse(coarse, coarse_solver, coarse_pressure);
        constexpr double tolerance = 1e-5;
        const auto conditions = fem_reference::dof_conditions(fine_load_case, fine);
        auto mixed = is_nested ? fem_reference::MixedSolver(
                                     fine, fine_solver, fine_pressure, tolerance, mixed_coarse,
                                     fem_reference::nested_iteration(coarse, coarse_pressure, fine, fine_pressure))
                               : fem_reference::MixedSolver(fine, fine_solver, fine_pressure, tolerance);
        const auto solution = mixed.solve(conditions.prescribed, conditions.load);
        EXPECT_TRUE(solution.unique && solution.converged);
        return solution.iterations;
    };
    EXPECT_LT(num_iterations(true), num_iterations(false));
}

/// Whatever the tolerance of the iterations.
TEST(FemMixed, ReactionsBalanceTheLoads) {
    auto problem = rod(0.49, 0.499, {3, 2, 2});
    problem.load_case.acceleration.setZero();
    const auto fine = core::refine(problem);
    fem_reference::StaticSolver direct(problem.body, 2, SolverChoice::direct, Formulation::mixed);
    fem_reference::StaticSolver in_haste(fine.body, direct, 1e-3);
    for (const auto &found : {direct.solve(problem.load_case), in_haste.solve(fine.load_case)}) {
        Vector3 sum = 0.08 * 0.06 * Vector3(20.0, -10.0, 5.0);
        const double size = sum.norm();
        for (const auto &reaction : found.reaction)
            sum += reaction;
        EXPECT_LT(sum.norm(), 1e-8 * size);
    }
}

/// The pressure jumps between a stiff material and a soft one: a layered bar that is squeezed sideways in a rigid tube
/// has a stress that does not depend on the place and another strain in each layer.
TEST(FemMixed, LetsThePressureJumpBetweenRegions) {
    auto problem = rod(0.45, 0.49, {4, 2, 2});
    const auto &mesh = problem.body->mesh;
    problem.load_case = tests::held(mesh);
    for (const auto *const patch : {"y_min", "y_max"})
        tests::prescribe(problem.load_case, mesh, patch, {nan, 0.0, nan});
    for (const auto *const patch : {"z_min", "z_max"})
        tests::prescribe(problem.load_case, mesh, patch, {nan, nan, 0.0});
    tests::pull(problem.load_case, mesh, "x_max", {-100.0, 0.0, 0.0});
    const auto strain = [&](int region) {
        const auto &material = problem.body->materials[region];
        return -100.0 / (material.lame_lambda() + 2.0 * material.shear_modulus());
    };
    std::vector<Vector3> expected;
    for (const auto &x : mesh.points)
        expected.emplace_back(strain(0) * std::min(x.x(), 0.05) + strain(1) * std::max(x.x() - 0.05, 0.0), 0.0, 0.0);
    for (const auto &[degree, formulation] :
         {std::pair(1, Formulation::displacement), {2, Formulation::displacement}, {2, Formulation::mixed}}) {
        const auto found = fem_reference::solve_static(problem, degree, SolverChoice::direct, formulation);
        ASSERT_EQ(found.status, core::SolutionStatus::ok) << found.message;
        EXPECT_LT(tests::relative_difference(found.displacement, expected), 1e-8);
    }
}

TEST(FemMixed, RefusesLinearElements) {
    EXPECT_THROW(fem_reference::solve_static(rod(0.45, 0.45, {2, 2, 1}), 1, SolverChoice::direct, Formulation::mixed),
                 std::invalid_argument);
}

} // namespace livermark
