#include <gtest/gtest.h>

#include <string>

#include "fem_reference/linear/linear_elasticity.hpp"
#include "fem_reference/linear/solver_choice.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"

namespace livermark {

using fem_reference::SolverChoice;

/// A rod of two materials, constrained at one end, with a side that may slide and is moved: pulled and hanging.
TEST(FemOfALargeBody, SolvesQuadraticElementsOnTwoLevelsAsWithAFactor) {
    auto problem = tests::shaken_rod(0.45, {20, 16, 12});
    tests::pull(problem.load_case, problem.body->mesh, "x_max", {20.0, -10.0, 5.0});
    const auto found = fem_reference::solve_static(problem, 2, SolverChoice::automatic);
    ASSERT_GT(found.degrees_of_freedom, fem_reference::largest_direct_quadratic_system);
    EXPECT_NE(found.solver.find("two levels over CHOLMOD"), std::string::npos) << found.solver;
    const auto expected = fem_reference::solve_static(problem, 2, SolverChoice::direct);
    ASSERT_EQ(found.status, core::SolutionStatus::ok) << found.message;
    EXPECT_LT(tests::relative_difference(found.displacement, expected.displacement), 1e-8);
    EXPECT_LT(tests::relative_difference(found.reaction, expected.reaction), 1e-8);
    EXPECT_NEAR(found.strain_energy, expected.strain_energy, 1e-8 * expected.strain_energy);
}

/// None keeps it from moving.
TEST(FemOfALargeBody, SaysWhenItIsFreeToMove) {
    auto problem = tests::shaken_rod(0.45, {20, 16, 12});
    for (int f = 0; f < problem.load_case.num_facets(); ++f)
        problem.load_case.free_facet(f);
    tests::pull(problem.load_case, problem.body->mesh, "x_max", {20.0, -10.0, 5.0});
    EXPECT_EQ(fem_reference::solve_static(problem, 2).status, core::SolutionStatus::not_converged);
}

} // namespace livermark
