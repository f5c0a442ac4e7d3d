#include "studies/cutting/growing_cut.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/mesh/refinement.hpp"
#include "meshes/cutting/cut.hpp"
#include "msm/nodal_conditions.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/statics/equilibrium.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

using core::Vector3;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr core::Material tissue{1000.0, 5000.0, 0.3};

/// From the face x = 0 on at half the height, as wide as the strip and more.
BladeWay along_middle(double height, double from, double to, int num_steps) {
    const double z = 0.5 * height;
    return {{Vector3(from, -0.01, z), Vector3(from, 0.1, z), Vector3(to, 0.1, z), Vector3(to, -0.01, z)}, num_steps};
}

double strain_energy(const core::Body &body, const msm::Equilibrium &equilibrium, const msm::ElasticBody &springs) {
    auto positions = body.mesh.points;
    for (std::size_t i = 0; i < positions.size(); ++i)
        positions[i] += equilibrium.displacement[i];
    return msm::elastic_energy(springs, positions);
}

/// The strip of Rivlin and Thomas (1953, J. Polym. Sci. 10): pulled apart at its long edges and cut along its middle.
/// What is far behind the tip is unloaded, what is far before it is strained evenly, and the tip in between only goes
/// on: what a cut sets free over its area is the energy of even strain in the height. Lattice and strain are what the
/// springs have to have right for that, and nothing else.
TEST(GrowingCut, SetsFreeWhatAnEvenlyStrainedStripHasStoredInItsHeight) {
    const Vector3 size(0.12, 0.005, 0.02);
    constexpr double strain = 1e-3;
    const auto body = tests::make_body(tests::box_mesh(size, {24, 1, 4}), tissue);
    const auto stages = grow_cut(body, along_middle(size.z(), -0.01, 0.08, 9), {});
    ASSERT_EQ(stages.size(), 10U);
    const auto energy_of = [&](const CutStage &stage) {
        const auto &mesh = stage.body->mesh;
        auto load_case = tests::empty_load_case(mesh);
        tests::prescribe(load_case, mesh, "x_max", {0.0, nan, nan});
        tests::prescribe(load_case, mesh, "y_min", {nan, 0.0, nan});
        tests::prescribe(load_case, mesh, "y_max", {nan, 0.0, nan});
        tests::prescribe(load_case, mesh, "z_min", {nan, nan, 0.0});
        tests::prescribe(load_case, mesh, "z_max", {nan, nan, strain * size.z()});
        const auto springs =
            msm::coupled_springs_with_volume(*stage.body, msm::find_coupled_springs("nodal_neo_hookean"));
        const auto found = msm::find_equilibrium(springs, mesh.points,
                                                 msm::nodal_conditions({stage.body, load_case}, springs.node_mass));
        EXPECT_EQ(found.status, core::SolutionStatus::ok) << found.message;
        // Far behind the tip the halves are as far apart as the grips were moved, near it a little more.
        EXPECT_GT(opening(stage, found.displacement), 0.99 * strain * size.z());
        EXPECT_LT(opening(stage, found.displacement), 1.25 * strain * size.z());
        return strain_energy(*stage.body, found, springs);
    };
    const double nu = tissue.poisson_ratio;
    const double even = 0.5 * tissue.young_modulus / (1.0 - nu * nu) * strain * strain * size.z(); // [J/m^2]
    const auto &early = stages[6], &late = stages[8];
    EXPECT_NEAR(late.area - early.area, 0.02 * size.y(), 1e-12);
    const double rate = (energy_of(early) - energy_of(late)) / (late.area - early.area);
    EXPECT_NEAR(rate, even, 0.01 * even);
}

/// As a set of faces in space, which does not know how nodes are numbered.
std::vector<std::array<double, 3>> wound_of(const core::TetraMesh &mesh) {
    std::vector<std::array<double, 3>> middles;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == meshes::wound_patch) {
            const auto &[a, b, c] = mesh.boundary_triangles[f];
            const Vector3 middle = (mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3.0;
            middles.push_back({middle.x(), middle.y(), middle.z()});
        }
    std::ranges::sort(middles);
    return middles;
}

TEST(GrowingCut, LeavesTheSameBodyInOneStepAndInTwenty) {
    const Vector3 size(0.08, 0.02, 0.02);
    const auto body = tests::make_body(tests::box_mesh(size, {16, 4, 4}), tissue);
    const auto at_once = grow_cut(body, along_middle(size.z(), -0.001, 0.051, 1), {});
    const auto in_steps = grow_cut(body, along_middle(size.z(), -0.001, 0.051, 20), {});
    ASSERT_EQ(at_once.size(), 2U);
    ASSERT_EQ(in_steps.size(), 21U);
    const auto &one = at_once.back().body->mesh, &other = in_steps.back().body->mesh;
    EXPECT_EQ(one.num_nodes(), other.num_nodes());
    EXPECT_EQ(one.num_tetrahedra(), other.num_tetrahedra());
    EXPECT_EQ(wound_of(one), wound_of(other));
    EXPECT_NEAR(at_once.back().area, 0.05 * size.y(), 1e-12);
    EXPECT_NEAR(in_steps.back().area, at_once.back().area, 1e-12);
    EXPECT_EQ(in_steps.back().parted.size(), at_once.back().parted.size());
    for (std::size_t k = 1; k < in_steps.size(); ++k)
        EXPECT_GE(in_steps[k].area, in_steps[k - 1].area) << k;
}

TEST(GrowingCut, MeetsTheBodyWhereItIs) {
    const Vector3 size(0.08, 0.02, 0.02);
    const auto body = tests::make_body(tests::box_mesh(size, {16, 4, 4}), tissue);
    const Vector3 shift(0.01, 0.0, 0.0);
    const auto shifted = [&](const CutStage &stage) {
        return std::vector<Vector3>(stage.body->mesh.points.size(), shift);
    };
    const auto moved = grow_cut(body, along_middle(size.z(), 0.0, 0.05, 5), shifted);
    const auto at_rest = grow_cut(body, along_middle(size.z(), -0.01, 0.04, 5), {});
    EXPECT_EQ(wound_of(moved.back().body->mesh), wound_of(at_rest.back().body->mesh));
    EXPECT_GT(at_rest.back().area, 0.0);
    for (const auto &[one, other] : moved.back().parted)
        EXPECT_EQ(moved.back().body->mesh.points[one], moved.back().body->mesh.points[other]);
}

/// Of the facets at the end of the blade, and nobody at its mouth or on its way.
TEST(GrowingCut, EndsAtARim) {
    const Vector3 size(0.08, 0.02, 0.02);
    const auto body = tests::make_body(tests::box_mesh(size, {16, 4, 4}), tissue);
    const auto stage = grow_cut(body, along_middle(size.z(), -0.001, 0.051, 1), {}).back();
    const auto expect_rim = [&](const core::TetraMesh &mesh) {
        const auto is_rim = wound_rim_nodes(mesh);
        for (int node = 0; node < mesh.num_nodes(); ++node) {
            const auto &x = mesh.points[node];
            EXPECT_EQ(is_rim[node], std::abs(x.x() - 0.05) < 1e-9 && std::abs(x.z() - 0.01) < 1e-9) << x.transpose();
        }
        return std::ranges::count(is_rim, true);
    };
    EXPECT_EQ(expect_rim(stage.body->mesh), 5);
    const core::Problem problem{stage.body, tests::empty_load_case(stage.body->mesh)};
    const auto finer = core::refine_at_rims_and(problem, wound_rim_nodes(stage.body->mesh)).problem;
    EXPECT_EQ(expect_rim(finer.body->mesh), 9);
    for (const auto &nodes : finer.body->mesh.tetrahedra) { // at the other end nothing was cut
        const bool is_far = std::ranges::all_of(nodes, [&](int n) { return finer.body->mesh.points[n].x() < 0.035; });
        if (is_far) {
            EXPECT_TRUE(std::ranges::all_of(nodes, [&](int n) { return n < stage.body->mesh.num_nodes(); }));
        }
    }
}

TEST(GrowingCut, CanBeMadeExactlyInOneStep) {
    const Vector3 size(0.08, 0.02, 0.02);
    const auto body = tests::make_body(tests::box_mesh(size, {16, 4, 4}), tissue);
    auto way = along_middle(size.z(), -0.001, 0.051, 5);
    for (auto &corner : way.corners)
        corner.z() += 0.002; // between two layers of nodes
    const auto along_facets = grow_cut(body, way, {}).back(), exact = cut_exactly(*body, way);
    EXPECT_DOUBLE_EQ(exact.depth, along_facets.depth);
    EXPECT_GT(exact.body->mesh.num_tetrahedra(), along_facets.body->mesh.num_tetrahedra());
    const double edge = 0.005; // by which the end may be short
    EXPECT_LT(exact.area, 0.051 * size.y());
    EXPECT_GT(exact.area, (0.05 - 1.5 * edge) * size.y());
    EXPECT_FALSE(exact.parted.empty());
    const auto is_rim = wound_rim_nodes(exact.body->mesh);
    EXPECT_GT(std::ranges::count(is_rim, true), 4);
    for (const auto &[one, other] : exact.parted)
        EXPECT_EQ(exact.body->mesh.points[one], exact.body->mesh.points[other]);
    EXPECT_THROW(cut_exactly(*body, along_middle(0.2, 0.0, 0.02, 3)), meshes::CutNotOnBody);
}

TEST(GrowingCut, RefusesABladeThatMissesOnAllOfItsWay) {
    const auto body = tests::make_body(tests::box_mesh({0.02, 0.02, 0.02}, {2, 2, 2}), tissue);
    EXPECT_THROW(grow_cut(body, along_middle(0.2, 0.0, 0.02, 3), {}), meshes::CutNotOnBody);
}

} // namespace
} // namespace livermark::studies
