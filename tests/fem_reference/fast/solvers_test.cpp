#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <set>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/mesh/refinement.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"
#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "fem_reference/solvers/matrices.hpp"
#include "fem_reference/solvers/two_level.hpp"
#include "meshes/generators/box_generator.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/not_a_number.hpp"

namespace livermark {
namespace {

core::Body box_body() {
    core::Body body;
    body.mesh = tests::shaken_box_mesh({0.1, 0.08, 0.06}, {3, 2, 2});
    body.materials = {{1060.0, 5000.0, 0.4}};
    return body;
}

/// Quadratic elements on a shaken box: rows of all lengths.
fem_reference::ElasticSystem box_system() {
    return fem_reference::assemble(box_body(), 2);
}

Eigen::MatrixXd dense(const fem_reference::SymmetricBlocks<double> &matrix) {
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(matrix.num_rows(), matrix.num_rows());
    const auto put = [&](int row, int column, const fem_reference::Block<double> &block) {
        const Eigen::Matrix3d values = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Map(block.data());
        full.block<3, 3>(3 * column, 3 * row) = values.transpose();
        full.block<3, 3>(3 * row, 3 * column) = values;
    };
    for (int node = 0; 3 * node < matrix.num_rows(); ++node) {
        put(node, node, matrix.diagonal[node]);
        for (int k = matrix.rows.row_start[node]; k < matrix.rows.row_start[node + 1]; ++k)
            put(node, matrix.rows.column[k], matrix.below[k]);
    }
    return full;
}

template <class T> std::vector<T> some_vector(int size) {
    std::vector<T> vector(size);
    for (int i = 0; i < size; ++i)
        vector[i] = static_cast<T>((7 * i + 3) % 23 - 11);
    return vector;
}

/// One of some columns that stand side by side.
template <class T> Eigen::VectorXd column(const std::vector<T> &together, int number, int lanes) {
    Eigen::VectorXd result(static_cast<Eigen::Index>(together.size()) / lanes);
    for (Eigen::Index i = 0; i < result.size(); ++i)
        result[i] = static_cast<double>(together[lanes * i + number]);
    return result;
}

/// Numbered otherwise it is the same system.
TEST(FemBlocks, SystemsByDistanceAreThoseOfTheMesh) {
    for (const int degree : {1, 2}) {
        const auto body = box_body();
        const auto in_mesh_order = fem_reference::assemble(body, degree);
        const auto by_distance = fem_reference::assemble(body, degree, fem_reference::NodeOrder::by_distance);
        ASSERT_EQ(by_distance.num_nodes(), in_mesh_order.num_nodes());
        std::vector<int> place(in_mesh_order.points.size(), -1);
        for (std::size_t k = 0; k < in_mesh_order.cell_nodes.size(); ++k)
            place[in_mesh_order.cell_nodes[k]] = by_distance.cell_nodes[k];
        EXPECT_NE(place, in_mesh_order.mesh_node);
        for (std::size_t node = 0; node < body.mesh.points.size(); ++node) {
            EXPECT_EQ(by_distance.mesh_node[node], place[node]);
            EXPECT_EQ(by_distance.points[place[node]], body.mesh.points[node]);
        }
        for (std::size_t k = 0; k < in_mesh_order.facet_nodes.size(); ++k)
            EXPECT_EQ(by_distance.facet_nodes[k], place[in_mesh_order.facet_nodes[k]]);
        Eigen::VectorXi dof(3 * in_mesh_order.num_nodes());
        for (int row = 0; row < dof.size(); ++row)
            dof[row] = 3 * place[row / 3] + row % 3;
        const Eigen::MatrixXd expected = dense(in_mesh_order.stiffness);
        EXPECT_LT((dense(by_distance.stiffness)(dof, dof) - expected).norm(), 1e-14 * expected.norm());
    }
}

template <class T> class FemBlocksProducts : public testing::Test {};
using Numbers = testing::Types<float, double>;
TYPED_TEST_SUITE(FemBlocksProducts, Numbers);

TYPED_TEST(FemBlocksProducts, AreThoseOfTheWholeMatrix) {
    using T = TypeParam;
    const double tolerance = 50.0 * static_cast<double>(std::numeric_limits<T>::epsilon());
    const auto matrix = box_system().stiffness;
    const Eigen::MatrixXd full = dense(matrix);
    for (const int lanes : {1, 4, 8}) {
        const auto x = some_vector<T>(lanes * matrix.num_rows());
        std::vector<T> blocks(x.size()), rows(x.size());
        if constexpr (std::is_same_v<T, float>)
            rounded(matrix).multiply(x, blocks);
        else
            matrix.multiply(x, blocks);
        fem_reference::multiply(compressed_rows(matrix), std::span<const T>(x), std::span<T>(rows), lanes);
        for (int c = 0; c < lanes; ++c) {
            const Eigen::VectorXd expected = full * column(x, c, lanes);
            EXPECT_LT((column(blocks, c, lanes) - expected).norm(), tolerance * expected.norm())
                << c << " of " << lanes;
            EXPECT_LT((column(rows, c, lanes) - expected).norm(), tolerance * expected.norm()) << c << " of " << lanes;
        }
    }
}

TEST(FemBlocks, CompressedRowsAreTheWholeMatrix) {
    const auto blocks = box_system().stiffness;
    const auto matrix = compressed_rows(blocks);
    for (int row = 0; row < matrix.num_rows(); ++row)
        EXPECT_TRUE(std::is_sorted(matrix.column.begin() + matrix.row_start[row],
                                   matrix.column.begin() + matrix.row_start[row + 1], std::less_equal<>()));
    EXPECT_EQ(tests::dense(matrix), dense(blocks));
    EXPECT_EQ(matrix.value.size(), 9 * (2 * blocks.below.size() + blocks.diagonal.size()));
}

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
    std::vector<double> out(u.size());
    stiffness.multiply(u, out);
    return out;
}

struct NestedSystems {
    core::Problem problem = stretched_rod(0.45);
    fem_reference::ElasticSystem coarse = fem_reference::assemble(*problem.body, 2);
    fem_reference::ElasticSystem fine = fem_reference::assemble(core::refine(*problem.body), 2);
    fem_reference::Prolongation prolongation = fem_reference::prolongation(coarse, fine);
};

} // namespace

/// Quadratic ones on a refined mesh and on parts of tetrahedra, linear ones from linear elements of the same body.
TEST(Prolongation, KeepsTheFieldsOfItsElements) {
    const NestedSystems systems;
    const auto expect_kept = [](const fem_reference::Prolongation &prolongation, const auto &coarse, const auto &fine,
                                const auto &field) {
        std::vector<double> prolonged(3 * fine.points.size(), 0.0);
        prolongation.add_prolonged(field(coarse.points), prolonged);
        const auto exact = field(fine.points);
        for (std::size_t dof = 0; dof < exact.size(); ++dof)
            EXPECT_NEAR(prolonged[dof], exact[dof], 1e-14);
    };
    expect_kept(systems.prolongation, systems.coarse, systems.fine, quadratic_field);
    const auto linear = fem_reference::assemble(*systems.problem.body, 1);
    expect_kept(fem_reference::prolongation(linear, systems.coarse), linear, systems.coarse, [](const auto &points) {
        std::vector<double> u;
        for (const auto &x : points)
            u.insert(u.end(), {1.0 + x.x(), 2.0 * x.y() - x.z(), x.x() + 3.0 * x.z()});
        return u;
    });
    const auto refined = core::refine_at_rims(systems.problem);
    const auto parts = fem_reference::assemble(*refined.problem.body, 2);
    expect_kept(fem_reference::prolongation(systems.coarse, parts, refined.parent_tetrahedron), systems.coarse, parts,
                quadratic_field);
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

/// P^T K P of linear elasticity is the matrix of the coarse elements themselves.
TEST(Galerkin, IsTheStiffnessOfLinearElements) {
    const auto problem = stretched_rod(0.45);
    const auto linear = fem_reference::assemble(*problem.body, 1),
               quadratic = fem_reference::assemble(*problem.body, 2);
    const auto found = fem_reference::galerkin(fem_reference::prolongation(linear, quadratic), quadratic.stiffness,
                                               linear.stiffness.rows);
    EXPECT_LT((dense(found) - dense(linear.stiffness)).cwiseAbs().maxCoeff(), 1e-12 * linear.stiffness.diagonal[0][0]);
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
    auto other = tests::held(problem.body->mesh, "z_min");
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

/// One of two parts that do not hang together is constrained, and the other is not.
TEST(FemSolver, SaysWhenAPartIsFreeToMove) {
    const auto single = tests::box_mesh({0.1, 0.1, 0.1}, {1, 1, 1});
    auto mesh = tests::twice(single, {1.0, 0.0, 0.0});
    mesh.boundary_triangles = single.boundary_triangles;
    mesh.boundary_patch = single.boundary_patch;
    const auto body = tests::make_body(mesh, {1000.0, 5000.0, 0.3});
    auto load_case = tests::held(mesh);
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

    fem_reference::ElasticSystem system = fem_reference::assemble(*stretched_rod(0.3).body, 2);
    std::size_t last_constrained = stretched_rod(0.3).body->mesh.points.size() - 1;
    std::vector<double> prescribed, load, more;
};

TEST_F(FemFactorOfFewer, SolvesAsAFactorOfAllDoes) {
    fem_reference::ConstrainedSolver own(compressed_rows(system.stiffness)), shared(compressed_rows(system.stiffness));
    shared.prepare(prescribed);
    const auto expected = own.solve(more, load), found = shared.solve(more, load);
    ASSERT_TRUE(expected.unique && found.unique);
    EXPECT_LT(tests::relative_l2(found.displacement, expected.displacement), 1e-11);
    EXPECT_LT(tests::relative_l2(found.residual, expected.residual), 1e-10);
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

} // namespace livermark
