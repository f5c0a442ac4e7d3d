#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/error_norms.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/not_a_number.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {

namespace {

using core::Vector3;
using tests::nan;
const core::Material soft{1060.0, 5000.0, 0.45};
const Vector3 box_size(0.1, 0.08, 0.06);

/// Parameter: degree of the elements.
class FemLoadCases : public testing::TestWithParam<int> {
  protected:
    std::shared_ptr<const core::Body> body = tests::make_body(tests::shaken_box_mesh(box_size, {4, 3, 3}), soft);
    const core::TetraMesh &mesh = body->mesh;
    core::LoadCase load_case = tests::empty_load_case(mesh);
};

Vector3 sum(const std::vector<Vector3> &vectors) {
    return std::accumulate(vectors.begin(), vectors.end(), Vector3(Vector3::Zero()));
}

bool same_bits(const core::Solution &a, const core::Solution &b) {
    return a.displacement == b.displacement && a.reaction == b.reaction && a.strain_energy == b.strain_energy;
}

/// A random order of 0 ... size - 1: entry i is where i goes.
std::vector<int> shuffled(int size, unsigned seed) {
    std::vector<int> order(size);
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), std::mt19937(seed));
    return order;
}

} // namespace

TEST_P(FemLoadCases, ReactionsBalanceTractionsAndGravity) {
    tests::prescribe(load_case, mesh, "z_min", Vector3::Zero());
    tests::prescribe(load_case, mesh, "z_max", {0.001, nan, -0.002});
    const Vector3 side(3.0, -7.0, 11.0), front(-2.0, 5.0, 1.0);
    tests::pull(load_case, mesh, "x_max", side); // shares edges with both constraints
    tests::pull(load_case, mesh, "y_min", front);
    load_case.acceleration = {0.1, -0.2, -0.3};
    const auto solution = fem_reference::solve_static({body, load_case}, GetParam());
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;

    const Vector3 load = soft.density * box_size.prod() * load_case.acceleration + box_size.y() * box_size.z() * side +
                         box_size.x() * box_size.z() * front;
    double largest = 0.0;
    for (const auto &reaction : solution.reaction)
        largest = std::max(largest, reaction.norm());
    EXPECT_GT(largest, load.norm());
    EXPECT_LT((sum(solution.reaction) + load).norm(), 1e-9 * load.norm());
    EXPECT_DOUBLE_EQ(solution.reaction[1].y(), 0.0); // what is free pulls at nothing
}

/// All that is prescribed on the sides is linear, and so is the solution, midpoints of edges included: by a factor at
/// the nodes, or where the displacement of each node is given, in all directions.
TEST_P(FemLoadCases, WhatIsPrescribedAtTheNodesIsLinearBetweenThem) {
    const Vector3 value(0.001, -0.002, 0.0005);
    Eigen::Matrix3d gradient;
    gradient << 0.01, 0.02, -0.01, 0.0, -0.02, 0.005, 0.01, 0.0, 0.01; // without change of volume
    auto by_factor = load_case, by_shift = load_case;
    for (const auto &patch : mesh.patch_names) {
        tests::prescribe(by_factor, mesh, patch, value);
        tests::prescribe(by_shift, mesh, patch, Vector3::Zero());
    }
    for (const auto &point : mesh.points) {
        by_factor.node_factor.push_back(1.0 + 3.0 * point.x() / box_size.x());
        by_shift.node_shift.emplace_back(gradient * point);
    }
    const auto factor = fem_reference::solve_static({body, by_factor}, GetParam());
    const auto shift = fem_reference::solve_static({body, by_shift}, GetParam());
    ASSERT_EQ(factor.status, core::SolutionStatus::ok) << factor.message;
    ASSERT_EQ(shift.status, core::SolutionStatus::ok) << shift.message;
    for (int node = 0; node < mesh.num_nodes(); ++node) {
        EXPECT_LT((factor.displacement[node] - by_factor.node_factor[node] * value).norm(), 1e-10 * value.norm());
        EXPECT_LT((shift.displacement[node] - by_shift.node_shift[node]).norm(), 1e-11);
    }
}

/// Forces at the nodes do the work of the traction on every displacement that the elements have, and so on x^degree.
TEST_P(FemLoadCases, WhatARoundToolPressesDoesItsWork) {
    const core::RoundLoad tool{{0.05, 0.03, box_size.z()}, 0.025};
    tests::prescribe(load_case, mesh, "z_min", Vector3::Zero());
    tests::pull(load_case, mesh, "z_max", {0.0, 0.0, -100.0});
    load_case.conditions.back().round = tool;
    double expected = 0.0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        if (!load_case.is_loaded(f))
            continue;
        const auto corners = core::corners_of(mesh, f);
        load_case.value[f] *= core::mean_height(tool, corners);
        core::visit_triangle_parts([&](const Vector3 &at) {
            const Vector3 point = core::point_at(corners, at);
            expected += core::area_vector(mesh, f).norm() / core::num_triangle_parts * -100.0 * tool.height(point) *
                        std::pow(point.x(), GetParam());
        });
    }
    const auto system = fem_reference::assemble(*body, GetParam());
    const auto load = fem_reference::dof_conditions(load_case, system).load;
    double work = 0.0;
    for (int node = 0; node < system.num_nodes(); ++node)
        work += load[3 * node + 2] * std::pow(system.points[node].x(), GetParam());
    EXPECT_NEAR(work, expected, 1e-12 * std::abs(expected));
}

/// For linear elements under a given load alone, the work at the tool is twice the strain energy (Clapeyron); under a
/// depth energies are as forces.
TEST_P(FemLoadCases, StiffnessAtTheToolIsTheRatioOfEnergies) {
    if (GetParam() != 1)
        return; // whose midpoints of edges the nodes of the mesh do not know
    const auto other = tests::make_body(mesh, {1060.0, 7000.0, 0.3});
    tests::prescribe(load_case, mesh, "z_min", Vector3::Zero());
    auto pressed = load_case;
    tests::press(pressed, mesh, "x_max", {-1.0, 0.0, -0.5}, 0.001);
    const core::RoundLoad tool{{0.05, 0.03, box_size.z()}, 0.025};
    tests::pull(load_case, mesh, "z_max", {0.0, 0.0, -100.0});
    load_case.conditions.back().round = tool;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.load_on(f) == 0)
            load_case.value[f] *= core::mean_height(tool, core::corners_of(mesh, f));
    const auto compared = [&](const core::LoadCase &of) {
        const auto solution = fem_reference::solve_static({other, of}, 1);
        const auto reference = fem_reference::solve_static({body, of}, 1);
        return core::compare(mesh, of, solution, reference, "soft");
    };
    const auto given = compared(load_case), to_depth = compared(pressed);
    EXPECT_GT(given.tool.value().stiffness(), 0.1);
    EXPECT_NEAR(given.tool->stiffness(), 1.0 / (1.0 + given.energy_error) - 1.0, 1e-9);
    EXPECT_GT(to_depth.tool.value().stiffness(), 0.1);
    EXPECT_NEAR(to_depth.tool->stiffness(), to_depth.energy_error, 1e-8);
}

/// A press to a depth is a load: the one that it reports.
TEST_P(FemLoadCases, PressesWithTheForceThatMovesAsFar) {
    using fem_reference::Formulation, fem_reference::SolverChoice;
    const double depth = 0.002;
    const Vector3 direction = Vector3(1.0, 2.0, -5.0).normalized();
    tests::prescribe(load_case, mesh, "z_min", Vector3::Zero());
    auto pulled = load_case;
    tests::press(load_case, mesh, "z_max", direction, depth);
    for (const auto formulation : {Formulation::displacement, Formulation::mixed}) {
        if (formulation == Formulation::mixed && GetParam() == 1)
            continue;
        const auto pressed =
            fem_reference::solve_static({body, load_case}, GetParam(), SolverChoice::automatic, formulation);
        ASSERT_EQ(pressed.status, core::SolutionStatus::ok) << pressed.message;
        const double force = pressed.reaction[1].norm();
        EXPECT_LT((pressed.reaction[1] - force * direction).norm(), 1e-12 * force);
        EXPECT_LT(sum(pressed.reaction).norm(), 1e-6 * force);
        EXPECT_NEAR(pressed.strain_energy, 0.5 * force * depth, 1e-9 * force * depth); // Clapeyron
        tests::pull(pulled, mesh, "z_max", force / (box_size.x() * box_size.y()) * direction);
        const auto found = fem_reference::solve_static({body, pulled}, GetParam(), SolverChoice::direct, formulation);
        EXPECT_LT(tests::relative_difference(pressed.displacement, found.displacement), 1e-7);
        const auto twice = fem_reference::solve_static({body, core::scaled(load_case, -2.0)}, GetParam(),
                                                       SolverChoice::automatic, formulation);
        EXPECT_LT((twice.reaction[1] + 2.0 * pressed.reaction[1]).norm(), 1e-9 * force);
    }
}

TEST_P(FemLoadCases, NumberingOfTheMeshIsKept) {
    tests::prescribe(load_case, mesh, "x_min", Vector3::Zero());
    tests::pull(load_case, mesh, "x_max", {1.0, -2.0, 3.0});
    load_case.acceleration = {0.1, -0.2, -0.3};
    const auto expected = fem_reference::solve_static({body, load_case}, GetParam());

    const auto new_node = shuffled(mesh.num_nodes(), 1);
    const auto new_cell = shuffled(mesh.num_tetrahedra(), 2);
    const auto new_facet = shuffled(mesh.num_boundary_triangles(), 3);
    core::TetraMesh other = mesh;
    for (int node = 0; node < mesh.num_nodes(); ++node)
        other.points[new_node[node]] = mesh.points[node];
    for (int t = 0; t < mesh.num_tetrahedra(); ++t) {
        const auto &[a, b, c, d] = mesh.tetrahedra[t];
        const std::array turned{b, c, a, d}; // an even permutation keeps the volume positive
        for (int v = 0; v < 4; ++v)
            other.tetrahedra[new_cell[t]][v] = new_node[t % 2 == 0 ? turned[v] : mesh.tetrahedra[t][v]];
    }
    core::LoadCase other_load_case = load_case;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        for (int v = 0; v < 3; ++v)
            other.boundary_triangles[new_facet[f]][v] = new_node[mesh.boundary_triangles[f][v]];
        other_load_case.condition_on[new_facet[f]] = load_case.condition_on[f];
        other_load_case.value[new_facet[f]] = load_case.value[f];
    }
    const auto solution = fem_reference::solve_static({tests::make_body(other, soft), other_load_case}, GetParam());
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
    std::vector<Vector3> back;
    for (int node = 0; node < mesh.num_nodes(); ++node)
        back.push_back(solution.displacement[new_node[node]]);
    EXPECT_LT(tests::relative_difference(back, expected.displacement), 1e-10);
    EXPECT_LT(tests::relative_difference(solution.reaction, expected.reaction), 1e-10);
}

TEST_P(FemLoadCases, StrainEnergyIsHalfTheWorkOfTheLoads) {
    tests::prescribe(load_case, mesh, "x_min", Vector3::Zero());
    tests::pull(load_case, mesh, "x_max", {1.0, -2.0, 3.0});
    load_case.acceleration = {0.1, -0.2, -0.3};
    const auto solution = fem_reference::solve_static({body, load_case}, GetParam());
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;

    const auto system = fem_reference::assemble(*body, GetParam());
    const auto conditions = fem_reference::dof_conditions(load_case, system);
    fem_reference::ConstrainedSolver solver(compressed_rows(system.stiffness));
    const auto &u = solver.solve(conditions.prescribed, conditions.load).displacement;
    const double work = std::inner_product(u.begin(), u.end(), conditions.load.begin(), 0.0);
    EXPECT_NEAR(solution.strain_energy, 0.5 * work, 1e-10 * work);
    // With every unknown prescribed and no load, the energy is that of the stiffness alone.
    const auto imposed = solver.solve(u, std::vector<double>(u.size(), 0.0));
    EXPECT_NEAR(solution.strain_energy, imposed.energy, 1e-10 * work);
}

TEST_P(FemLoadCases, PrescribedFacetsMoveWhollyAsPrescribedByTheWorkOfTheirReactions) {
    const Vector3 motion(0.001, -0.002, 0.003);
    load_case = tests::held(mesh);
    tests::prescribe(load_case, mesh, "x_max", motion);
    const auto solution = fem_reference::solve_static({body, load_case}, GetParam());
    EXPECT_NEAR(solution.strain_energy, 0.5 * motion.dot(solution.reaction[1]), 1e-10 * solution.strain_energy);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.is_constrained(f)) {
            for (const int node : mesh.boundary_triangles[f])
                EXPECT_EQ(solution.displacement[node], load_case.value[f]);
        }

    // A single tetrahedron has all its nodes on facets: if the midpoints did not move along, it would be strained.
    const auto single = tests::make_body(tests::regular_tetrahedron(0.1), soft);
    auto moved = tests::empty_load_case(single->mesh);
    tests::prescribe(moved, single->mesh, "surface", motion);
    const auto rigid = fem_reference::solve_static({single, moved}, GetParam());
    EXPECT_EQ(rigid.status, core::SolutionStatus::ok);
    EXPECT_EQ(rigid.degrees_of_freedom, GetParam() == 1 ? 12 : 30);
    EXPECT_LT(std::abs(rigid.strain_energy), 1e-12 * soft.young_modulus * 0.1 * motion.squaredNorm());
}

TEST_P(FemLoadCases, BodyFreeToMoveIsReported) {
    const auto failure = [&](const core::LoadCase &loads) {
        const auto solution = fem_reference::solve_static({body, loads}, GetParam());
        EXPECT_EQ(solution.status, core::SolutionStatus::not_converged);
        EXPECT_FALSE(solution.message.empty());
        EXPECT_EQ(solution.displacement.size(), mesh.points.size());
        EXPECT_TRUE(std::isnan(solution.displacement.front().x()));
        EXPECT_EQ(solution.reaction.size(), loads.constraint_names().size());
    };
    load_case.acceleration = {0.0, 0.0, -0.1};
    failure(load_case); // not constrained at all
    tests::prescribe(load_case, mesh, "x_min", {0.0, nan, nan});
    failure(load_case); // slides and spins in a plane
    tests::prescribe(load_case, mesh, "y_min", {nan, 0.0, nan});
    failure(load_case); // slides along a line

    tests::prescribe(load_case, mesh, "z_min", {nan, nan, 0.0});
    EXPECT_EQ(fem_reference::solve_static({body, load_case}, GetParam()).status, core::SolutionStatus::ok);
}

TEST_P(FemLoadCases, SlenderBodyConstrainedAtOneEndIsNotTakenForAFreeOne) {
    const core::Material hard_to_compress{1060.0, 5000.0, 0.499};
    const auto rod = tests::make_body(tests::box_mesh({1.0, 0.01, 0.01}, {100, 1, 1}), hard_to_compress);
    auto loads = tests::held(rod->mesh);
    tests::pull(loads, rod->mesh, "x_max", {0.0, 0.0, 1e-5});
    const auto solution = fem_reference::solve_static({rod, loads}, GetParam());
    EXPECT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
}

TEST_P(FemLoadCases, FirstConstraintOwnsWhatTwoConstraintsShare) {
    tests::prescribe(load_case, mesh, "x_min", {0.0, 0.0, nan});
    tests::prescribe(load_case, mesh, "z_min", {0.001, 0.002, 0.003});
    const auto solution = fem_reference::solve_static({body, load_case}, GetParam());
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
    int num_shared = 0;
    for (int node = 0; node < mesh.num_nodes(); ++node)
        if (mesh.points[node].x() == 0.0 && mesh.points[node].z() == 0.0) {
            ++num_shared;
            EXPECT_EQ(solution.displacement[node], Vector3(0.0, 0.0, 0.003));
        }
    EXPECT_EQ(num_shared, 4);
    EXPECT_DOUBLE_EQ(solution.reaction[0].z(), 0.0);
}

TEST_P(FemLoadCases, ReusedFactorGivesTheBitsOfANewOne) {
    tests::prescribe(load_case, mesh, "x_min", Vector3::Zero());
    tests::prescribe(load_case, mesh, "x_max", {0.001, nan, nan});
    auto second = load_case;
    for (auto &value : second.value)
        value *= -3.0;
    second.acceleration = {0.1, 0.2, 0.3};
    auto third = tests::empty_load_case(mesh); // other constraints
    tests::prescribe(third, mesh, "y_min", Vector3::Zero());
    third.acceleration = {0.0, 0.0, -0.1};

    fem_reference::StaticSolver solver(body, GetParam());
    const auto first_solution = solver.solve(load_case);
    const auto second_solution = solver.solve(second);
    EXPECT_EQ(second_solution.setup_seconds, first_solution.setup_seconds); // not factored again
    EXPECT_TRUE(same_bits(first_solution, fem_reference::solve_static({body, load_case}, GetParam())));
    EXPECT_TRUE(same_bits(second_solution, fem_reference::solve_static({body, second}, GetParam())));
    EXPECT_TRUE(same_bits(solver.solve(third), fem_reference::solve_static({body, third}, GetParam())));
    EXPECT_TRUE(same_bits(solver.solve(load_case), first_solution));
}

TEST_P(FemLoadCases, LoadCaseOfAnotherMeshIsRefused) {
    load_case.condition_on.pop_back();
    EXPECT_THROW(fem_reference::solve_static({body, load_case}, GetParam()), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Degree, FemLoadCases, testing::Values(1, 2));

TEST(FemReference, RefusesOtherDegrees) {
    const auto body = tests::make_body(tests::regular_tetrahedron(0.1), soft);
    EXPECT_THROW(fem_reference::StaticSolver(body, 0), std::invalid_argument);
    EXPECT_THROW(fem_reference::StaticSolver(body, 3), std::invalid_argument);
}

TEST(FemReference, RefusesABoundaryTriangleInside) {
    auto mesh = tests::box_mesh(box_size, {1, 1, 1});
    mesh.boundary_triangles.push_back({mesh.tetrahedra[0][0], mesh.tetrahedra[0][1], mesh.tetrahedra[0][3]});
    mesh.boundary_patch.push_back(0);
    EXPECT_THROW(fem_reference::assemble(*tests::make_body(mesh, soft), 1), std::invalid_argument);
}

namespace {

/// Parameter: degree of the elements.
class FemPatch : public testing::TestWithParam<int> {};

std::vector<Vector3> affine_field(const std::vector<Vector3> &points, const Eigen::Matrix3d &gradient,
                                  const Vector3 &shift) {
    std::vector<Vector3> field;
    for (const auto &point : points)
        field.push_back(gradient * point + shift);
    return field;
}

std::vector<double> flat(const std::vector<Vector3> &field) {
    std::vector<double> values;
    for (const auto &vector : field)
        values.insert(values.end(), {vector.x(), vector.y(), vector.z()});
    return values;
}

} // namespace

TEST_P(FemPatch, AffineBoundaryDisplacementGivesTheAffineField) {
    const auto body = tests::make_body(tests::shaken_box_mesh(box_size, {4, 3, 3}), soft);
    const auto system = fem_reference::assemble(*body, GetParam());
    Eigen::Matrix3d gradient;
    gradient << 0.01, -0.02, 0.005, 0.03, -0.01, 0.02, -0.015, 0.007, 0.02;
    const auto exact = affine_field(system.points, gradient, {0.001, -0.002, 0.003});
    std::vector<double> prescribed(3 * exact.size(), nan);
    for (const int node : system.facet_nodes)
        for (int i = 0; i < 3; ++i)
            prescribed[3 * node + i] = exact[node][i];
    ASSERT_GT(std::ranges::count_if(prescribed, [](double value) { return std::isnan(value); }), 0);

    fem_reference::ConstrainedSolver solver(compressed_rows(system.stiffness));
    const auto found = solver.solve(prescribed, std::vector<double>(prescribed.size(), 0.0));
    ASSERT_TRUE(found.unique);
    std::vector<Vector3> displacement;
    for (std::size_t node = 0; node < exact.size(); ++node)
        displacement.push_back(Vector3::Map(&found.displacement[3 * node]));
    EXPECT_LT(tests::relative_difference(displacement, exact), 1e-10);

    // W = V (lambda/2 tr(eps)^2 + mu eps : eps)
    const Eigen::Matrix3d strain = 0.5 * (gradient + gradient.transpose());
    const double energy = box_size.prod() * (0.5 * soft.lame_lambda() * strain.trace() * strain.trace() +
                                             soft.shear_modulus() * strain.squaredNorm());
    EXPECT_NEAR(found.energy, energy, 1e-10 * energy);
}

TEST_P(FemPatch, UniaxialTractionGivesYoungModulusAndPoissonRatio) {
    const auto body = tests::make_body(tests::shaken_box_mesh(box_size, {4, 3, 3}), soft);
    const auto &mesh = body->mesh;
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "x_min", {0.0, nan, nan});
    tests::prescribe(load_case, mesh, "y_min", {nan, 0.0, nan});
    tests::prescribe(load_case, mesh, "z_min", {nan, nan, 0.0});
    const double traction = 50.0;
    tests::pull(load_case, mesh, "x_max", {traction, 0.0, 0.0});
    const auto solution = fem_reference::solve_static({body, load_case}, GetParam());
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;

    const double strain = traction / soft.young_modulus;
    const Eigen::Matrix3d gradient =
        Vector3(strain, -soft.poisson_ratio * strain, -soft.poisson_ratio * strain).asDiagonal();
    EXPECT_LT(tests::relative_difference(solution.displacement, affine_field(mesh.points, gradient, Vector3::Zero())),
              1e-10);
    const double area = box_size.y() * box_size.z();
    EXPECT_LT(tests::relative_difference(solution.reaction,
                                         {Vector3(-traction * area, 0.0, 0.0), Vector3::Zero(), Vector3::Zero()}),
              1e-9);
    const double energy = 0.5 * traction * strain * box_size.prod();
    EXPECT_NEAR(solution.strain_energy, energy, 1e-10 * energy);
}

TEST_P(FemPatch, RigidMotionsCostNoEnergyAndNoForce) {
    const auto body = tests::make_body(tests::shaken_box_mesh(box_size, {4, 3, 3}), soft);
    const auto system = fem_reference::assemble(*body, GetParam());
    fem_reference::ConstrainedSolver solver(compressed_rows(system.stiffness));
    const auto forces_of = [&](const Eigen::Matrix3d &gradient) {
        const auto motion = flat(affine_field(system.points, gradient, {0.01, -0.02, 0.03}));
        return solver.solve(motion, std::vector<double>(motion.size(), 0.0));
    };
    Eigen::Matrix3d spin;
    spin << 0.0, -0.3, 0.2, 0.3, 0.0, -0.1, -0.2, 0.1, 0.0;
    const auto rigid = forces_of(spin);
    const auto strained = forces_of(spin.cwiseAbs()); // same size, but no rotation
    const auto largest = [](const std::vector<double> &values) {
        return std::abs(*std::ranges::max_element(values, {}, [](double value) { return std::abs(value); }));
    };
    EXPECT_LT(std::abs(rigid.energy), 1e-12 * strained.energy);
    EXPECT_LT(largest(rigid.residual), 1e-12 * largest(strained.residual));
}

INSTANTIATE_TEST_SUITE_P(Degree, FemPatch, testing::Values(1, 2));

} // namespace livermark

namespace livermark::fem_reference {
namespace {

constexpr int no_factor = 0;

/// A box that is constrained at one end, and pulled at the other.
struct Pulled {
    explicit Pulled(double poisson_ratio) {
        body = tests::make_body(tests::box_mesh({0.09, 0.03, 0.03}, {9, 3, 3}), {1000.0, 5000.0, poisson_ratio});
        constrained = tests::held(body->mesh);
    }
    core::LoadCase load(const core::Vector3 &traction) const {
        auto load_case = constrained;
        tests::pull(load_case, body->mesh, "x_max", traction);
        return load_case;
    }
    std::shared_ptr<const core::Body> body;
    core::LoadCase constrained;
};

TEST(RepeatedLoads, AgreeWithTheStaticSolverWithAndWithoutAFactor) {
    for (const double poisson_ratio : {0.3, 0.45, 0.49}) {
        const Pulled pulled(poisson_ratio);
        StaticSolver expected(pulled.body, 2);
        std::vector<std::string> told;
        const auto tell = [&](const std::string &sentence) { told.push_back(sentence); };
        RepeatedLoads factor(*pulled.body, pulled.constrained, tell);
        RepeatedLoads levels(*pulled.body, pulled.constrained, tell, no_factor);
        EXPECT_EQ(told.size(), 4U);
        std::vector<double> last_of_factor, last_of_levels;
        for (const core::Vector3 &traction : {core::Vector3(100.0, 0.0, 0.0), {0.0, 50.0, -20.0}}) {
            const auto load_case = pulled.load(traction);
            const auto solution = expected.solve(load_case);
            const auto exact = factor.solve(load_case, last_of_factor);
            EXPECT_TRUE(exact.has_converged);
            EXPECT_LT(tests::relative_difference(exact.displacement, solution.displacement), 1e-9);
            EXPECT_NEAR(exact.work, 2.0 * solution.strain_energy, 1e-9 * exact.work);
            const auto near = levels.solve(load_case, last_of_levels);
            EXPECT_TRUE(near.has_converged);
            EXPECT_GT(near.iterations, 1);
            EXPECT_LT(tests::relative_difference(near.displacement, solution.displacement), 1e-4) << poisson_ratio;
            EXPECT_NEAR(near.work, exact.work, 1e-4 * exact.work);
        }
    }
}

/// StaticSolver finds what a newton on each place does at all of them.
TEST(RepeatedLoads, MoveUnderForcesOnPlacesInside) {
    const Pulled pulled(0.45);
    const core::Vector3 middle(0.045, 0.015, 0.015);
    InnerForces inner{{{middle, 0.008}, {middle + core::Vector3(0.004, 0.0, 0.0), 0.008}},
                      {{3.0, -1.0, 2.0}, {0.0, 4.0, 1.0}}};
    StaticSolver solver(pulled.body, 2);
    const auto compliance = solver.compliance(pulled.constrained, inner.places);
    const Eigen::VectorXd force = Eigen::Map<const Eigen::VectorXd>(inner.forces.front().data(), 6);
    for (const int largest : {no_factor, RepeatedLoads::largest_factor}) {
        RepeatedLoads loads(
            *pulled.body, pulled.constrained, [](const std::string &) {}, largest);
        std::vector<double> last;
        const auto found = loads.solve(pulled.constrained, last, inner);
        ASSERT_TRUE(found.has_converged);
        EXPECT_NEAR(found.work, force.dot(compliance.matrix * force), 1e-4 * found.work);
    }
    inner.places.front().middle.x() += 100.0;
    RepeatedLoads loads(*pulled.body, pulled.constrained, [](const std::string &) {});
    std::vector<double> last;
    EXPECT_THROW(loads.solve(pulled.constrained, last, inner), std::invalid_argument);
}

TEST(RepeatedLoads, NeedFewerIterationsNearTheLastSolution) {
    const Pulled pulled(0.45);
    RepeatedLoads levels(
        *pulled.body, pulled.constrained, [](const std::string &) {}, no_factor);
    std::vector<double> last;
    const auto first = levels.solve(pulled.load({0.0, 50.0, 0.0}), last);
    const auto same = levels.solve(pulled.load({0.0, 50.0, 0.0}), last);
    EXPECT_LE(same.iterations, 1);
    EXPECT_LT(tests::relative_difference(same.displacement, first.displacement), 1e-5);
    const auto near = levels.solve(pulled.load({0.0, 50.5, 0.0}), last);
    EXPECT_GT(near.iterations, 0);
    EXPECT_LT(near.iterations, first.iterations);
}

TEST(RepeatedLoads, ClearTheLastSolutionWhenNothingPulls) {
    const Pulled pulled(0.45);
    for (const int largest : {no_factor, RepeatedLoads::largest_factor}) {
        RepeatedLoads loads(
            *pulled.body, pulled.constrained, [](const std::string &) {}, largest);
        std::vector<double> last;
        loads.solve(pulled.load({0.0, 50.0, 0.0}), last);
        const auto displacement = loads.solve(pulled.constrained, last).displacement;
        ASSERT_EQ(displacement.size(), pulled.body->mesh.points.size());
        for (const auto &u : displacement)
            EXPECT_EQ(u.norm(), 0.0);
    }
}

TEST(RepeatedLoads, SayWhenNothingHoldsTheBody) {
    const Pulled pulled(0.45);
    const auto free = tests::empty_load_case(pulled.body->mesh);
    for (const int largest : {no_factor, RepeatedLoads::largest_factor}) {
        RepeatedLoads loads(
            *pulled.body, free, [](const std::string &) {}, largest);
        std::vector<double> last;
        const auto solution = loads.solve(free, last);
        EXPECT_FALSE(solution.is_unique);
        EXPECT_FALSE(solution.has_converged);
        EXPECT_TRUE(last.empty());
    }
}

} // namespace
} // namespace livermark::fem_reference
