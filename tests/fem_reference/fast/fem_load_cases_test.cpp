#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "core/error_norms.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/not_a_number.hpp"

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

/// What is prescribed on all sides is linear in x, and so is the solution, midpoints of edges included.
TEST_P(FemLoadCases, AFactorAtTheNodesIsLinearBetweenThem) {
    const Vector3 value(0.001, -0.002, 0.0005);
    for (const auto &patch : mesh.patch_names)
        tests::prescribe(load_case, mesh, patch, value);
    for (const auto &point : mesh.points)
        load_case.node_factor.push_back(1.0 + 3.0 * point.x() / box_size.x());
    const auto solution = fem_reference::solve_static({body, load_case}, GetParam());
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
    for (int node = 0; node < mesh.num_nodes(); ++node)
        EXPECT_LT((solution.displacement[node] - load_case.node_factor[node] * value).norm(), 1e-10 * value.norm());
}

/// The same where the displacement of each node is given, in all directions.
TEST_P(FemLoadCases, AShiftOfTheNodesIsLinearBetweenThem) {
    Eigen::Matrix3d gradient;
    gradient << 0.01, 0.02, -0.01, 0.0, -0.02, 0.005, 0.01, 0.0, 0.01; // without change of volume
    for (const auto &patch : mesh.patch_names)
        tests::prescribe(load_case, mesh, patch, Vector3::Zero());
    for (const auto &point : mesh.points)
        load_case.node_shift.emplace_back(gradient * point);
    const auto solution = fem_reference::solve_static({body, load_case}, GetParam());
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
    for (int node = 0; node < mesh.num_nodes(); ++node)
        EXPECT_LT((solution.displacement[node] - load_case.node_shift[node]).norm(), 1e-11);
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

/// Of linear elements under a given load alone, the work at the tool is twice the strain energy (Clapeyron); under a
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

/// What presses to a depth is a load: the one that it reports.
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

    // The same loads by hand: linear shape functions share volume and area equally; of quadratic ones the corners get
    // -1/20 of the volume and nothing of the area, the midpoints 1/5 and 1/3.
    const auto system = fem_reference::assemble(*body, GetParam());
    const auto add = [](std::vector<double> &load, int node, const Vector3 &force) {
        for (int i = 0; i < 3; ++i)
            load[3 * node + i] += force[i];
    };
    std::vector<double> load(3 * system.points.size(), 0.0);
    std::vector<double> prescribed(load.size(), nan);
    const auto volumes = core::tetrahedron_volumes(mesh);
    for (std::size_t k = 0; k < system.cell_nodes.size(); ++k) {
        const int node = system.cell_nodes[k];
        const double share = GetParam() == 1 ? 0.25 : node < mesh.num_nodes() ? -0.05 : 0.2;
        add(load, node, soft.density * volumes[k / system.nodes_per_cell] * share * load_case.acceleration);
    }
    for (std::size_t k = 0; k < system.facet_nodes.size(); ++k) {
        const int facet = static_cast<int>(k) / system.nodes_per_facet;
        const int node = system.facet_nodes[k];
        const double share = GetParam() == 2 && node < mesh.num_nodes() ? 0.0 : 1.0 / 3.0;
        if (load_case.is_loaded(facet))
            add(load, node, core::area_vector(mesh, facet).norm() * share * load_case.value[facet]);
        if (load_case.is_constrained(facet))
            std::fill_n(prescribed.begin() + 3 * node, 3, 0.0);
    }
    fem_reference::ConstrainedSolver solver(compressed_rows(system.stiffness));
    const auto by_hand = solver.solve(prescribed, load);
    const double work = std::inner_product(load.begin(), load.end(), by_hand.displacement.begin(), 0.0);
    EXPECT_NEAR(solution.strain_energy, 0.5 * work, 1e-10 * work);
    // With every unknown prescribed and no load, the energy is that of the stiffness alone.
    const auto imposed = solver.solve(by_hand.displacement, std::vector<double>(load.size(), 0.0));
    EXPECT_NEAR(solution.strain_energy, imposed.energy, 1e-10 * work);
}

TEST_P(FemLoadCases, StrainEnergyIsHalfTheWorkOfTheReactions) {
    const Vector3 motion(0.001, -0.002, 0.003);
    tests::prescribe(load_case, mesh, "x_min", Vector3::Zero());
    tests::prescribe(load_case, mesh, "x_max", motion);
    const auto solution = fem_reference::solve_static({body, load_case}, GetParam());
    EXPECT_NEAR(solution.strain_energy, 0.5 * motion.dot(solution.reaction[1]), 1e-10 * solution.strain_energy);
}

TEST_P(FemLoadCases, PrescribedFacetsMoveWhollyAsPrescribed) {
    const Vector3 motion(0.001, -0.002, 0.003);
    tests::prescribe(load_case, mesh, "x_min", Vector3::Zero());
    tests::prescribe(load_case, mesh, "x_max", motion);
    const auto solution = fem_reference::solve_static({body, load_case}, GetParam());
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
    auto loads = tests::empty_load_case(rod->mesh);
    tests::prescribe(loads, rod->mesh, "x_min", Vector3::Zero());
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

} // namespace livermark
