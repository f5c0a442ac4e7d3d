#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <iterator>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/mesh/places.hpp"
#include "core/mesh/refinement.hpp"
#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "fem_reference/solvers/two_level.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/not_a_number.hpp"
#include "tests/samples/even_foundation.hpp"
#include "tests/samples/standing_block.hpp"
#include "tests/samples/test_meshes.hpp"

/// Linear elements on elastic foundations.
namespace livermark {

namespace {

using core::Vector3;
using fem_reference::Formulation;
using fem_reference::SolverChoice;
using fem_reference::StaticSolver;
using tests::nan;
namespace standing = tests::standing;

struct LinearKind {
    int degree;
    Formulation formulation;
};
constexpr std::array linear_kinds{LinearKind{1, Formulation::displacement}, LinearKind{2, Formulation::displacement},
                                  LinearKind{2, Formulation::mixed}};

std::vector<int> facets_on(const core::TetraMesh &mesh, const std::string &patch) {
    std::vector<int> facets;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == patch)
            facets.push_back(f);
    return facets;
}

/// A bar along x that is held at one end and stands on springs of some sides.
core::Problem bar_on_springs(const Vector3 &size, const std::array<int, 3> &bricks, double young_modulus,
                             const std::vector<std::string> &sides, double stiffness, bool normal_only) {
    const auto body = tests::make_body(tests::box_mesh(size, bricks), {1000.0, young_modulus, 0.0});
    auto load_case = tests::held(body->mesh);
    std::vector<int> facets;
    for (const auto &side : sides)
        std::ranges::copy(facets_on(body->mesh, side), std::back_inserter(facets));
    std::ranges::sort(facets);
    load_case.foundation = tests::even_foundation(facets, stiffness, normal_only);
    return {body, load_case};
}

StaticSolver mixed_solver_of(const core::Problem &problem, SolverChoice choice) {
    return {problem.body,
            2,
            choice,
            Formulation::mixed,
            fem_reference::largest_direct_coarse_system,
            problem.load_case.foundation};
}

/// A rod that stands on two sides, in all directions on one of them.
core::Problem standing_rod(const std::array<int, 3> &bricks) {
    auto problem = tests::shaken_rod(0.49, bricks);
    const auto &mesh = problem.body->mesh;
    tests::pull(problem.load_case, mesh, "z_max", {5.0, -10.0, 20.0});
    auto facets = facets_on(mesh, "z_min");
    std::ranges::copy(facets_on(mesh, "x_max"), std::back_inserter(facets));
    std::ranges::sort(facets);
    problem.load_case.foundation = tests::even_foundation(facets, 3e5, false);
    for (std::size_t which = 0; which < facets.size(); ++which)
        problem.load_case.foundation->normal_only[which] =
            mesh.patch_names[mesh.boundary_patch[facets[which]]] == "z_min" ? 1 : 0;
    return problem;
}

void expect_near_solution(const core::Solution &found, const core::Solution &expected, double tolerance) {
    ASSERT_EQ(found.status, core::SolutionStatus::ok) << found.message;
    ASSERT_EQ(expected.status, core::SolutionStatus::ok) << expected.message;
    EXPECT_LT(tests::relative_difference(found.displacement, expected.displacement), tolerance);
    EXPECT_LT(tests::relative_difference(found.reaction, expected.reaction), tolerance);
    EXPECT_NEAR(found.strain_energy, expected.strain_energy, tolerance * expected.strain_energy);
}

} // namespace

/// The springs and the block are in series, whatever Poisson's ratio; the energy is that of the block alone.
TEST(LinearFoundation, GoesAsFarAsTheClosedForm) {
    for (const auto &kind : linear_kinds)
        for (const auto &[top, traction] : standing::drives) {
            auto problem = standing::block(top, traction, 0.45);
            problem.load_case.regime = core::Regime::small;
            problem.load_case.path.clear();
            const auto solution =
                fem_reference::solve_static(problem, kind.degree, SolverChoice::automatic, kind.formulation);
            ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
            const double expected = standing::expected(top, traction);
            EXPECT_NEAR(standing::moved_up(problem.body->mesh, solution.displacement), expected, 1e-7 * expected);
            EXPECT_LT(standing::out_of_balance(problem, solution.displacement, solution.reaction), 1e-7);
            const double area = standing::size.x() * standing::size.y();
            const double energy =
                0.5 * standing::young_modulus * area / standing::size.z() * (top - expected) * (top - expected);
            EXPECT_NEAR(solution.strain_energy, energy, 1e-6 * energy);
        }
}

/// E I w'''' + k b w = 0 with a force at the tip: w = 2 P l / (k b) (sinh cosh - sin cos) / (cosh^2 + cos^2) of l L,
/// with l^4 = k b / (4 E I). (M. Hetenyi 1946, Beams on Elastic Foundation)
TEST(LinearFoundation, BearsABeamAsWinkler) {
    const Vector3 size(0.2, 0.008, 0.01);
    constexpr double young_modulus = 1e5, force = 1e-4;
    const double inertia = size.y() * std::pow(size.z(), 3) / 12.0;
    for (const double stiffness : {1e2, 1e3}) {
        auto problem = bar_on_springs(size, {40, 1, 2}, young_modulus, {"z_min"}, stiffness, true);
        tests::pull(problem.load_case, problem.body->mesh, "x_max", {0.0, 0.0, force / (size.y() * size.z())});
        const auto solution = fem_reference::solve_static(problem, 2);
        double tip = 0.0;
        int num_there = 0;
        for (std::size_t node = 0; node < solution.displacement.size(); ++node)
            if (problem.body->mesh.points[node].x() > 0.999 * size.x()) {
                tip += solution.displacement[node].z();
                ++num_there;
            }
        tip /= num_there;
        const double below = stiffness * size.y(); // per length
        const double lambda = std::pow(below / (4.0 * young_modulus * inertia), 0.25), x = lambda * size.x();
        const double expected = 2.0 * force * lambda / below *
                                (std::sinh(x) * std::cosh(x) - std::sin(x) * std::cos(x)) /
                                (std::cosh(x) * std::cosh(x) + std::cos(x) * std::cos(x));
        EXPECT_GT(x, 1.0);
        EXPECT_NEAR(tip, expected, 0.01 * expected);
    }
}

/// Along its plane: without Poisson's ratio a bar that is pulled along it does not feel it. In all directions it does,
/// as E A u'' = 2 k b u between springs of two sides: u = t / E tanh(m L) / m with m^2 = 2 k b / (E A), as long as the
/// bar is thin.
TEST(LinearFoundation, AlongTheNormalAloneLetsABarSlide) {
    const Vector3 size(0.1, 0.01, 0.004);
    constexpr double young_modulus = 1e5, traction = 100.0, stiffness = 1e4;
    for (const auto &kind : linear_kinds)
        for (const bool normal_only : {true, false}) {
            auto problem = bar_on_springs(size, {20, 1, 1}, young_modulus, {"z_min", "z_max"}, stiffness, normal_only);
            tests::pull(problem.load_case, problem.body->mesh, "x_max", {traction, 0.0, 0.0});
            const auto solution =
                fem_reference::solve_static(problem, kind.degree, SolverChoice::automatic, kind.formulation);
            const double m = std::sqrt(2.0 * stiffness / (young_modulus * size.z()));
            for (std::size_t node = 0; node < solution.displacement.size(); ++node) {
                const Vector3 &x = problem.body->mesh.points[node];
                if (normal_only)
                    EXPECT_NEAR(solution.displacement[node].x(), traction / young_modulus * x.x(), 1e-10 * size.x());
                else if (x.x() > 0.999 * size.x()) {
                    const double expected = traction / young_modulus * std::tanh(m * size.x()) / m;
                    EXPECT_NEAR(solution.displacement[node].x(), expected, 0.01 * expected);
                }
            }
        }
}

/// At loads so small that all is linear.
TEST(LinearFoundation, IsThatOfHyperelasticElementsUnderSmallLoads) {
    for (const auto &kind : linear_kinds) {
        auto problem = standing_rod({3, 2, 2});
        problem.load_case = core::scaled(problem.load_case, 1e-3);
        const auto linear = fem_reference::solve_static(problem, kind.degree, SolverChoice::direct, kind.formulation);
        const auto large = hyperelastic::solve(problem, hyperelastic::material_law("neo_hookean"),
                                               {.degree = kind.degree, .formulation = kind.formulation},
                                               {.fractions = {1.0}, .tolerance = 1e-9});
        expect_near_solution(linear, large.solution, 1e-4);
    }
}

/// Directly, by multigrid, by two levels and on a refined mesh, alone and together.
TEST(LinearFoundation, IsTheSameByAllSolvers) {
    const auto problem = standing_rod({3, 2, 2});
    const auto direct = mixed_solver_of(problem, SolverChoice::direct).solve(problem.load_case);
    expect_near_solution(mixed_solver_of(problem, SolverChoice::iterative).solve(problem.load_case), direct, 1e-7);
    auto coarse = mixed_solver_of(problem, SolverChoice::automatic);
    auto hanging = problem.load_case;
    hanging.acceleration = {0.0, 3.0, 1.0};
    const auto together = coarse.solve(std::array{problem.load_case, hanging});
    ASSERT_EQ(together.size(), 2U);
    expect_near_solution(together[0], direct, 1e-7);
    expect_near_solution(together[1], mixed_solver_of(problem, SolverChoice::direct).solve(hanging), 1e-7);

    const auto fine = core::refine(problem);
    StaticSolver two_levels(fine.body, coarse, 1e-9, {}, fine.load_case.foundation);
    expect_near_solution(two_levels.solve(fine.load_case),
                         mixed_solver_of(fine, SolverChoice::direct).solve(fine.load_case), 1e-7);
}

/// The residual where a body is free has no resultant and no moment after that, with springs and without.
TEST(LinearFoundation, IsBalancedByRigidMotionsOfWhatIsFree) {
    auto problem = standing_rod({3, 2, 2});
    for (const bool is_borne : {true, false}) {
        if (!is_borne)
            problem.load_case.foundation.reset();
        const auto system =
            fem_reference::assemble(*problem.body, 2, fem_reference::NodeOrder::of_mesh, problem.load_case.foundation);
        EXPECT_EQ(system.is_borne, is_borne);
        const auto prescribed = fem_reference::dof_conditions(problem.load_case, system).prescribed;
        const std::vector<std::span<const double>> columns{prescribed};
        const auto free = fem_reference::free_unknowns(columns);
        ASSERT_EQ(free.lanes(), 1);
        std::vector<double> residual(prescribed.size()), u(prescribed.size(), 0.0), product(prescribed.size());
        for (std::size_t dof = 0; dof < residual.size(); ++dof)
            residual[dof] = std::isnan(prescribed[dof]) ? 1.0 + std::sin(static_cast<double>(dof)) : 0.0;
        fem_reference::balance(system, free, residual, u);
        system.stiffness.multiply(u, product);
        Vector3 force = Vector3::Zero(), moment = Vector3::Zero(), first = Vector3::Zero();
        for (int node = 0; node < system.num_nodes(); ++node) {
            Vector3 left = Vector3::Zero();
            for (int i = 0; i < 3; ++i)
                if (const int dof = 3 * node + i; std::isnan(prescribed[dof]))
                    left[i] = residual[dof] - product[dof];
            force += left;
            moment += system.points[node].cross(left);
            first += Vector3::Map(&residual[3 * static_cast<std::size_t>(node)]);
        }
        EXPECT_LT(force.norm(), 1e-9 * first.norm());
        EXPECT_LT(moment.norm(), 1e-9 * first.norm() * tests::rod_size.norm());
    }
}

/// A stiff block swings on springs with omega^2 = k / (rho L).
TEST(LinearFoundation, HasAFrequency) {
    auto problem = standing::block(0.0, 0.0);
    const auto body = std::make_shared<core::Body>(*problem.body);
    body->materials.front().young_modulus = 1e4 * standing::young_modulus;
    problem.body = body;
    const auto foundation = problem.load_case.foundation;
    problem.load_case = tests::empty_load_case(body->mesh);
    problem.load_case.foundation = foundation;
    tests::prescribe(problem.load_case, body->mesh, "x_min", {0.0, nan, nan});
    tests::prescribe(problem.load_case, body->mesh, "y_min", {nan, 0.0, nan});
    const double expected = std::sqrt(standing::stiffness / (body->materials.front().density * standing::size.z()));
    for (const int degree : {1, 2})
        EXPECT_NEAR(fem_reference::lowest_modes(problem, degree, 1).angular_frequency.front(), expected,
                    1e-3 * expected);
}

/// Nothing is left out in silence.
TEST(LinearFoundation, IsNoOtherThanThatOfTheSolver) {
    const auto problem = standing_rod({2, 2, 2});
    auto alone = problem.load_case;
    alone.foundation.reset();
    auto softer = problem.load_case;
    softer.foundation->stiffness.front() *= 0.5;
    auto solver = mixed_solver_of(problem, SolverChoice::direct);
    EXPECT_THROW(solver.solve(alone), std::invalid_argument);
    EXPECT_THROW(solver.solve(softer), std::invalid_argument);
    const std::vector<core::InteriorPlace> inside{{{0.05, 0.04, 0.03}, 0.0}};
    EXPECT_THROW(solver.compliance(alone, inside), std::invalid_argument);
    EXPECT_THROW(StaticSolver(problem.body, 2).solve(problem.load_case), std::invalid_argument);
}

} // namespace livermark
