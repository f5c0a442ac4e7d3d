#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <stdexcept>

#include "core/mesh/refinement.hpp"
#include "core/problem.hpp"
#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "fem_reference/solvers/algebraic_multigrid.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "fem_reference/solvers/iterative_solver.hpp"
#include "fem_reference/solvers/two_level.hpp"
#include "meshes/generators/box_generator.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/not_a_number.hpp"

namespace livermark {
namespace {

using core::Vector3;
using fem_reference::SolverChoice;
using tests::nan;

/// A rod of two materials, constrained at one end, with a side that may slide and is moved: pulled and hanging.
core::Problem stretched_rod(double poisson_ratio, const std::array<int, 3> &bricks = {4, 3, 3}) {
    auto problem = tests::shaken_rod(poisson_ratio, bricks);
    tests::pull(problem.load_case, problem.body->mesh, "x_max", {20.0, -10.0, 5.0});
    return problem;
}

void expect_same_solution(const core::Solution &a, const core::Solution &b) {
    ASSERT_EQ(a.status, core::SolutionStatus::ok) << a.message;
    ASSERT_EQ(b.status, core::SolutionStatus::ok) << b.message;
    EXPECT_LT(tests::relative_difference(a.displacement, b.displacement), 1e-8);
    EXPECT_LT(tests::relative_difference(a.reaction, b.reaction), 1e-8);
    EXPECT_NEAR(a.strain_energy, b.strain_energy, 1e-8 * b.strain_energy);
}

std::vector<double> quadratic_field(const std::vector<Vector3> &points) {
    std::vector<double> field;
    for (const auto &p : points)
        field.insert(field.end(), {p.x() * p.y(), p.z() * p.z() - p.x(), 1.0 + p.y() * p.z()});
    return field;
}

std::vector<double> times(const fem_reference::SymmetricBlocks<double> &stiffness, const std::vector<double> &u) {
    const auto matrix = compressed_rows(stiffness);
    std::vector<double> out(u.size(), 0.0);
    for (int row = 0; row < matrix.num_rows(); ++row)
        for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k)
            out[row] += matrix.value[k] * u[matrix.column[k]];
    return out;
}

struct NestedSystems {
    core::Problem problem = stretched_rod(0.45);
    fem_reference::ElasticSystem coarse = fem_reference::assemble(*problem.body, 2);
    fem_reference::ElasticSystem fine = fem_reference::assemble(core::refine(*problem.body), 2);
    fem_reference::Prolongation prolongation = fem_reference::prolongation(coarse, fine);
};

} // namespace

TEST(Prolongation, KeepsQuadraticFields) {
    const NestedSystems systems;
    std::vector<double> fine(3 * systems.fine.points.size(), 0.0);
    systems.prolongation.add_prolonged(quadratic_field(systems.coarse.points), fine);
    const auto exact = quadratic_field(systems.fine.points);
    for (std::size_t dof = 0; dof < fine.size(); ++dof)
        EXPECT_NEAR(fine[dof], exact[dof], 1e-14);
}

TEST(Prolongation, KeepsLinearFieldsFromLinearElementsOfTheSameBody) {
    const NestedSystems systems;
    const auto linear = fem_reference::assemble(*systems.problem.body, 1);
    const auto prolongation = fem_reference::prolongation(linear, systems.coarse);
    const auto field = [](const std::vector<Vector3> &points) {
        std::vector<double> u;
        for (const auto &x : points)
            u.insert(u.end(), {1.0 + x.x(), 2.0 * x.y() - x.z(), x.x() + 3.0 * x.z()});
        return u;
    };
    std::vector<double> fine(3 * systems.coarse.points.size(), 0.0);
    prolongation.add_prolonged(field(linear.points), fine);
    const auto exact = field(systems.coarse.points);
    for (std::size_t dof = 0; dof < fine.size(); ++dof)
        EXPECT_NEAR(fine[dof], exact[dof], 1e-14);
}

/// The coarse functions are fine ones: P^T K P is the coarse stiffness matrix.
TEST(Prolongation, GivesTheCoarseStiffnessFromTheFineOne) {
    const NestedSystems systems;
    std::vector<double> u(3 * systems.coarse.points.size());
    for (std::size_t dof = 0; dof < u.size(); ++dof)
        u[dof] = std::sin(1.7 * static_cast<double>(dof));
    std::vector<double> prolonged(3 * systems.fine.points.size(), 0.0);
    systems.prolongation.add_prolonged(u, prolonged);
    std::vector<double> restricted(u.size());
    systems.prolongation.restrict_to(times(systems.fine.stiffness, prolonged), restricted);
    const auto expected = times(systems.coarse.stiffness, u);
    const double scale = *std::ranges::max_element(expected);
    for (std::size_t dof = 0; dof < u.size(); ++dof)
        EXPECT_NEAR(restricted[dof], expected[dof], 1e-11 * scale);
}

TEST(Prolongation, KeepsQuadraticFieldsOnPartsOfTetrahedra) {
    const auto problem = stretched_rod(0.45);
    const auto refined = core::refine_at_rims(problem);
    const auto coarse = fem_reference::assemble(*problem.body, 2),
               fine = fem_reference::assemble(*refined.problem.body, 2);
    const auto prolongation = fem_reference::prolongation(coarse, fine, refined.parent_tetrahedron);
    std::vector<double> prolonged(3 * fine.points.size(), 0.0);
    prolongation.add_prolonged(quadratic_field(coarse.points), prolonged);
    const auto exact = quadratic_field(fine.points);
    for (std::size_t dof = 0; dof < exact.size(); ++dof)
        EXPECT_NEAR(prolonged[dof], exact[dof], 1e-14);
}

/// Of linear elasticity P^T K P is the matrix of the coarse elements themselves.
TEST(Galerkin, IsTheStiffnessOfLinearElements) {
    const auto problem = stretched_rod(0.45);
    const auto linear = fem_reference::assemble(*problem.body, 1),
               quadratic = fem_reference::assemble(*problem.body, 2);
    const auto found = fem_reference::galerkin(fem_reference::prolongation(linear, quadratic), quadratic.stiffness,
                                               linear.stiffness.rows);
    const double scale = linear.stiffness.diagonal[0][0];
    ASSERT_EQ(found.diagonal.size(), linear.stiffness.diagonal.size());
    ASSERT_EQ(found.below.size(), linear.stiffness.below.size());
    for (std::size_t a = 0; a < found.diagonal.size(); ++a)
        for (int i = 0; i < 9; ++i)
            EXPECT_NEAR(found.diagonal[a][i], linear.stiffness.diagonal[a][i], 1e-12 * scale);
    for (std::size_t k = 0; k < found.below.size(); ++k)
        for (int i = 0; i < 9; ++i)
            EXPECT_NEAR(found.below[k][i], linear.stiffness.below[k][i], 1e-12 * scale);
}

TEST(Prolongation, IsTheSameInSinglePrecision) {
    const NestedSystems systems;
    const int lanes = 4;
    std::vector<double> coarse(lanes * 3 * systems.coarse.points.size());
    for (std::size_t i = 0; i < coarse.size(); ++i)
        coarse[i] = std::sin(1.7 * static_cast<double>(i));
    std::vector<double> fine(lanes * 3 * systems.fine.points.size(), 0.5), back(coarse.size());
    const std::vector<float> single_coarse(coarse.begin(), coarse.end());
    std::vector<float> single_fine(fine.begin(), fine.end()), single_back(coarse.size());
    systems.prolongation.add_prolonged(coarse, fine);
    systems.prolongation.add_prolonged(single_coarse, single_fine);
    systems.prolongation.restrict_to(fine, back);
    systems.prolongation.restrict_to(single_fine, single_back);
    for (std::size_t i = 0; i < fine.size(); ++i)
        ASSERT_NEAR(single_fine[i], fine[i], 1e-6);
    const double largest = *std::ranges::max_element(back);
    for (std::size_t i = 0; i < back.size(); ++i)
        ASSERT_NEAR(single_back[i], back[i], 1e-6 * largest);
}

TEST(Prolongation, RefusesASystemThatIsNotTheRefinedOne) {
    const NestedSystems systems;
    auto other = systems.fine;
    other.points.back() += Vector3(1e-3, 0.0, 0.0);
    EXPECT_THROW(fem_reference::prolongation(systems.coarse, systems.coarse), std::invalid_argument);
    EXPECT_THROW(fem_reference::prolongation(systems.coarse, other), std::invalid_argument);
}

/// Parameter: Poisson's ratio.
class FemSolvers : public testing::TestWithParam<double> {};

TEST_P(FemSolvers, TwoLevelsAgreeWithTheDirectSolver) {
    const auto problem = stretched_rod(GetParam(), {3, 2, 2});
    const auto fine = core::refine(problem);
    fem_reference::StaticSolver coarse(problem.body, 2);
    fem_reference::StaticSolver two_levels(fine.body, coarse);
    const auto found = two_levels.solve(fine.load_case);
    expect_same_solution(found, fem_reference::solve_static(fine, 2, SolverChoice::direct));
    EXPECT_NE(found.solver.find("two levels over CHOLMOD"), std::string::npos) << found.solver;

    // Other constraints on the coarse body in between must not disturb the fine one, nor the other way round.
    auto other = tests::empty_load_case(problem.body->mesh);
    tests::prescribe(other, problem.body->mesh, "z_min", Vector3::Zero());
    other.acceleration = {0.0, 1.0, 0.0};
    coarse.solve(other);
    expect_same_solution(two_levels.solve(fine.load_case), found);
    expect_same_solution(
        two_levels.solve(core::refine(other, problem.body->mesh)),
        fem_reference::solve_static({fine.body, core::refine(other, problem.body->mesh)}, 2, SolverChoice::direct));
}

TEST_P(FemSolvers, AlgebraicMultigridAgreesWithTheDirectSolver) {
    const auto problem = stretched_rod(GetParam());
    for (const int degree : {1, 2}) {
        const auto found = fem_reference::solve_static(problem, degree, SolverChoice::iterative);
        expect_same_solution(found, fem_reference::solve_static(problem, degree, SolverChoice::direct));
        EXPECT_NE(found.solver.find("ML"), std::string::npos) << found.solver;
    }
}

INSTANTIATE_TEST_SUITE_P(Poisson, FemSolvers, testing::Values(0.25, 0.45, 0.49));

/// Three levels: the preconditioner of the middle one corrects the finest.
TEST(FemSolver, ThreeLevelsAgreeWithTheDirectSolver) {
    const auto problem = stretched_rod(0.45, {1, 1, 1});
    const auto middle = core::refine(problem);
    const auto fine = core::refine(middle);
    fem_reference::StaticSolver first(problem.body, 2);
    fem_reference::StaticSolver second(middle.body, first);
    fem_reference::StaticSolver third(fine.body, second);
    expect_same_solution(third.solve(fine.load_case), fem_reference::solve_static(fine, 2, SolverChoice::direct));
}

TEST(FemSolver, IsDirectAtThisSizeUnlessForced) {
    const auto problem = stretched_rod(0.3, {2, 1, 1});
    EXPECT_EQ(fem_reference::solve_static(problem, 2).solver, "CHOLMOD");
    EXPECT_EQ(fem_reference::solve_static(problem, 2, SolverChoice::direct).solver, "CHOLMOD");
    EXPECT_TRUE(fem_reference::solve_static(problem, 2, SolverChoice::iterative).solver.starts_with("CG, "));
}

TEST(FemSolver, SaysWhenABodyIsFreeToMove) {
    auto problem = stretched_rod(0.3, {2, 1, 1});
    problem.load_case = tests::empty_load_case(problem.body->mesh);
    tests::prescribe(problem.load_case, problem.body->mesh, "x_min", {0.0, 0.0, nan}); // may slide along z
    problem.load_case.acceleration = {0.0, 0.0, 1.0};
    const auto found = fem_reference::solve_static(problem, 2, SolverChoice::iterative);
    EXPECT_EQ(found.status, core::SolutionStatus::not_converged);
    EXPECT_NE(found.message.find("free to move"), std::string::npos);
    EXPECT_TRUE(std::isnan(found.strain_energy));

    const auto fine = core::refine(problem);
    fem_reference::StaticSolver coarse(problem.body, 2);
    fem_reference::StaticSolver two_levels(fine.body, coarse);
    EXPECT_EQ(two_levels.solve(fine.load_case).status, core::SolutionStatus::not_converged);
}

/// Of two parts that do not hang together one is constrained and the other not.
TEST(FemSolver, SaysWhenAPartIsFreeToMove) {
    auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {1, 1, 1});
    const auto single = mesh;
    for (const auto &point : single.points)
        mesh.points.push_back(point + Vector3(1.0, 0.0, 0.0));
    const int shift = single.num_nodes();
    for (auto nodes : single.tetrahedra) {
        for (int &node : nodes)
            node += shift;
        mesh.tetrahedra.push_back(nodes);
    }
    mesh.region.resize(mesh.tetrahedra.size(), 0);
    const auto body = tests::make_body(mesh, {1000.0, 5000.0, 0.3});
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "x_min", Vector3::Zero());
    load_case.acceleration = {0.0, 0.0, 1.0};
    const auto found = fem_reference::solve_static({body, load_case}, 1, SolverChoice::iterative);
    EXPECT_EQ(found.status, core::SolutionStatus::not_converged);
    EXPECT_NE(found.message.find("free to move"), std::string::npos);
}

/// Conjugate gradients that stop early say so and give the last iterate.
TEST(FemSolver, SaysWhenConjugateGradientsStopEarly) {
    struct Nothing : fem_reference::Preconditioner {
        bool set_up(const fem_reference::FreeUnknowns &) override { return true; }
        void apply(std::span<const float> residual, std::span<float> correction) override {
            std::ranges::copy(residual, correction.begin());
        }
        std::string name() const override { return "none"; }
    };
    const auto problem = stretched_rod(0.45, {2, 1, 1});
    const auto system = fem_reference::assemble(*problem.body, 2);
    std::vector<double> prescribed(3 * system.points.size(), nan);
    std::fill_n(prescribed.begin(), 30, 0.0);
    const std::vector<double> load(prescribed.size(), 1e-4);
    const auto solve = [&](int max_iterations) {
        return fem_reference::IterativeSolver(system.stiffness, std::make_unique<Nothing>(), max_iterations)
            .solve(prescribed, load);
    };
    const auto early = solve(3);
    EXPECT_TRUE(early.unique);
    EXPECT_FALSE(early.converged);
    EXPECT_EQ(early.iterations, 3);
    EXPECT_GT(early.relative_residual, fem_reference::IterativeSolver::tolerance);
    EXPECT_GT(early.energy, 0.0);
    const auto late = solve(100000);
    EXPECT_TRUE(late.converged);
    EXPECT_LE(late.relative_residual, fem_reference::IterativeSolver::tolerance);
}

/// Conditions of a second load case that are those of the first and a few more.
class FemFactorOfFewer : public testing::Test {
  protected:
    FemFactorOfFewer() : prescribed(3 * system.points.size(), nan), load(3 * system.points.size(), 0.0) {
        for (std::size_t node = 0; node < system.points.size(); ++node)
            if (system.points[node].x() < 1e-9)
                std::fill_n(&prescribed[3 * node], 3, 0.0);
        more = prescribed;
        for (const std::size_t node : {last_constrained - 1, last_constrained}) {
            EXPECT_TRUE(std::isnan(more[3 * node])) << "constrained already";
            more[3 * node] = 0.001;
            more[3 * node + 2] = -0.002;
        }
        for (std::size_t i = 0; i < load.size(); ++i)
            load[i] = std::sin(static_cast<double>(i));
    }

    static double relative_difference(const std::vector<double> &a, const std::vector<double> &b) {
        const auto size = static_cast<Eigen::Index>(b.size());
        const Eigen::Map<const Eigen::VectorXd> x(a.data(), size), y(b.data(), size);
        return (x - y).norm() / y.norm();
    }

    fem_reference::ElasticSystem system = fem_reference::assemble(*stretched_rod(0.3).body, 2);
    std::size_t last_constrained = stretched_rod(0.3).body->mesh.points.size() - 1;
    std::vector<double> prescribed, load, more;
};

TEST_F(FemFactorOfFewer, SolvesAsAFactorOfAllDoes) {
    fem_reference::ConstrainedSolver own(compressed_rows(system.stiffness)), shared(compressed_rows(system.stiffness));
    shared.prepare(prescribed);
    const auto expected = own.solve(more, load), found = shared.solve(more, load);
    ASSERT_TRUE(expected.unique && found.unique);
    EXPECT_LT(relative_difference(found.displacement, expected.displacement), 1e-11);
    EXPECT_LT(relative_difference(found.residual, expected.residual), 1e-10);
    EXPECT_NEAR(found.energy, expected.energy, 1e-11 * expected.energy);
    EXPECT_NE(found.displacement, expected.displacement) << "it was not the shared factor";
    EXPECT_EQ(found.displacement[3 * last_constrained], 0.001);

    const auto first = shared.solve(prescribed, load);
    EXPECT_EQ(first.displacement, own.solve(prescribed, load).displacement) << "nothing more is constrained now";
    EXPECT_EQ(shared.solve(more, load).displacement, found.displacement) << "it depends on what was solved before";
}

TEST_F(FemFactorOfFewer, GivesWayToOneThatHoldsSomethingElse) {
    fem_reference::ConstrainedSolver own(compressed_rows(system.stiffness)), shared(compressed_rows(system.stiffness));
    shared.prepare(more); // of which the conditions leave some free
    EXPECT_EQ(shared.solve(prescribed, load).displacement, own.solve(prescribed, load).displacement);
}

TEST_F(FemFactorOfFewer, MayLeaveTheBodyFreeToMove) {
    const std::vector<double> nothing(prescribed.size(), nan);
    fem_reference::ConstrainedSolver shared(compressed_rows(system.stiffness)), own(compressed_rows(system.stiffness));
    shared.prepare(nothing);
    EXPECT_FALSE(shared.solve(nothing, load).unique);
    auto three_points = nothing;
    for (std::size_t k = 0; k < 3; ++k)
        std::fill_n(&three_points[3 * (k * system.points.size() / 3)], 3, 0.0);
    const auto found = shared.solve(three_points, load);
    ASSERT_TRUE(found.unique);
    EXPECT_EQ(found.displacement, own.solve(three_points, load).displacement);
}

// Rigid motions of a discretised body, and columns that are put in balance by them.

namespace {

using fem_reference::RigidModes;

fem_reference::ElasticSystem bar() {
    core::Body body;
    body.name = "bar";
    body.mesh = meshes::generate_box({0.3, 0.1, 0.1}, 0.05);
    body.materials = {{.density = 1000.0, .young_modulus = 5000.0, .poisson_ratio = 0.4}};
    return fem_reference::assemble(body, 2);
}

std::vector<double> multiply(const fem_reference::ElasticSystem &system, const std::vector<double> &u) {
    std::vector<double> out(u.size());
    system.stiffness.multiply(u, out);
    return out;
}

double norm(const std::vector<double> &vector) {
    return std::sqrt(fem_reference::dot(vector, vector));
}

TEST(RigidModes, TakeNoForce) {
    const auto system = bar();
    const RigidModes modes(system.points);
    for (int m = 0; m < RigidModes::count; ++m) {
        std::vector<double> u;
        for (const auto &point : system.points)
            for (int i = 0; i < 3; ++i)
                u.push_back(modes.at(point)(i, m));
        const auto rows = compressed_rows(system.stiffness);
        const double stiffest = *std::ranges::max_element(rows.value);
        EXPECT_LT(norm(multiply(system, u)), 1e-12 * stiffest * norm(u)) << m;
    }
}

/// Columns that constrain one end, or three nodes in six ways, and that begin out of balance by chance.
class Balance : public testing::Test {
  protected:
    Balance() {
        std::vector<double> at_end(num_unknowns, nan), in_six_ways = at_end;
        int first = -1, second = -1, third = -1;
        for (int node = 0; node < system.num_nodes(); ++node) {
            const auto &x = system.points[node];
            if (x.x() < 1e-9)
                for (int i = 0; i < 3; ++i)
                    at_end[3 * node + i] = 0.0;
            if (x.norm() < 1e-9)
                first = node;
            else if ((x - Vector3(0.3, 0.0, 0.0)).norm() < 1e-9)
                second = node;
            else if ((x - Vector3(0.0, 0.1, 0.0)).norm() < 1e-9)
                third = node;
        }
        for (const int dof : {3 * first, 3 * first + 1, 3 * first + 2, 3 * second + 1, 3 * second + 2, 3 * third + 2})
            in_six_ways[dof] = 0.0;
        free = fem_reference::free_unknowns(
            std::vector<std::span<const double>>{at_end, in_six_ways}); // two of four lanes
        std::mt19937 generator(5);
        std::normal_distribution<double> number;
        for (std::size_t i = 0; i < num_unknowns; ++i) {
            load.push_back(number(generator));
            for (int c = 0; c < 2; ++c)
                u[4 * i + c] = is_free(c, i) ? 1e-3 * number(generator) : 0.0;
        }
    }
    bool is_free(int column, std::size_t i) const { return free.sets[free.set[column]][i]; }
    std::vector<double> column(int c) const { return fem_reference::separated(u, 4, 2)[c]; }
    /// r = f - K u where free
    std::vector<double> residual(int c) const {
        auto out = multiply(system, column(c));
        for (std::size_t i = 0; i < num_unknowns; ++i)
            out[i] = is_free(c, i) ? load[i] - out[i] : 0.0;
        return out;
    }
    std::vector<double> residuals() const {
        std::vector<double> together(4 * num_unknowns, 0.0);
        for (int c = 0; c < 2; ++c) {
            const auto of_column = residual(c);
            for (std::size_t i = 0; i < num_unknowns; ++i)
                together[4 * i + c] = of_column[i];
        }
        return together;
    }
    double energy(int c) const { // 1/2 u^T K u - f^T u
        const auto displacement = column(c);
        return 0.5 * fem_reference::dot(displacement, multiply(system, displacement)) -
               fem_reference::dot(displacement, load);
    }

    fem_reference::ElasticSystem system = bar();
    std::size_t num_unknowns = 3 * system.points.size();
    fem_reference::FreeUnknowns free;
    std::vector<double> load, u = std::vector<double>(4 * num_unknowns, 0.0);
};

TEST_F(Balance, LeavesNeitherResultantNorMoment) {
    fem_reference::balance(system, free, residuals(), u);
    for (int c = 0; c < 2; ++c) {
        const auto left = residual(c);
        Vector3 resultant = Vector3::Zero(), moment = resultant;
        for (int node = 0; node < system.num_nodes(); ++node) {
            const auto force = Vector3::Map(&left[3 * node]);
            resultant += force;
            moment += system.points[node].cross(force);
        }
        EXPECT_LT(resultant.norm(), 1e-10 * norm(left)) << c;
        EXPECT_LT(moment.norm(), 1e-10 * norm(left)) << c;
        for (std::size_t i = 0; i < num_unknowns; ++i) {
            if (!is_free(c, i)) {
                EXPECT_EQ(u[4 * i + c], 0.0);
            }
        }
    }
    for (std::size_t i = 0; i < num_unknowns; ++i)
        EXPECT_EQ(u[4 * i + 2], 0.0); // no column needs this lane
}

TEST_F(Balance, GoesDownInTheEnergyAndThenStays) {
    const std::array before{energy(0), energy(1)};
    fem_reference::balance(system, free, residuals(), u);
    const auto once = u;
    for (int c = 0; c < 2; ++c)
        EXPECT_LT(energy(c), before[c]);
    fem_reference::balance(system, free, residuals(), u);
    for (std::size_t i = 0; i < u.size(); ++i)
        EXPECT_NEAR(u[i], once[i], 1e-9);
}

} // namespace
} // namespace livermark
