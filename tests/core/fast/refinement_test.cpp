#include "core/mesh/refinement.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>
#include <set>

#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::core {
namespace {

const Material soft{1060.0, 5000.0, 0.45};

/// Two regions, and inner nodes off the lattice, so that the octahedra are cut along different diagonals.
Body sample_body() {
    auto mesh = tests::shaken_box_mesh({0.1, 0.08, 0.06}, {3, 2, 2});
    mesh.region_names = {"near", "far"};
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        mesh.region[t] = t % 3 == 0;
    return *tests::make_body(std::move(mesh), soft);
}

std::vector<double> region_volumes(const TetraMesh &mesh) {
    std::vector<double> volumes(mesh.region_names.size(), 0.0);
    const auto of_tetrahedra = tetrahedron_volumes(mesh);
    for (std::size_t t = 0; t < of_tetrahedra.size(); ++t)
        volumes[mesh.region[t]] += of_tetrahedra[t];
    return volumes;
}

std::vector<Vector3> patch_area_vectors(const TetraMesh &mesh) {
    std::vector<Vector3> areas(mesh.patch_names.size(), Vector3::Zero());
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        areas[mesh.boundary_patch[f]] += area_vector(mesh, f);
    return areas;
}

/// Radius ratio 3 r_in / r_out, 1 for the regular tetrahedron and 0 for a flat one; the least of the mesh.
double least_quality(const TetraMesh &mesh) {
    double least = 1.0;
    for (const auto &[i, j, k, l] : mesh.tetrahedra) {
        const Vector3 &d = mesh.points[l];
        const Vector3 a = mesh.points[i] - d, b = mesh.points[j] - d, c = mesh.points[k] - d;
        const double surface =
            0.5 * (a.cross(b).norm() + b.cross(c).norm() + c.cross(a).norm() + (b - a).cross(c - a).norm());
        const double six_volumes = std::abs(a.dot(b.cross(c)));
        const double inner = 0.5 * six_volumes / surface;
        const double outer =
            (a.squaredNorm() * b.cross(c) + b.squaredNorm() * c.cross(a) + c.squaredNorm() * a.cross(b)).norm() /
            (2.0 * six_volumes);
        least = std::min(least, 3.0 * inner / outer);
    }
    return least;
}

std::set<std::array<int, 3>> with_first_node_least(const std::vector<std::array<int, 3>> &triangles) {
    std::set<std::array<int, 3>> result;
    for (auto triangle : triangles) {
        std::ranges::rotate(triangle, std::ranges::min_element(triangle));
        result.insert(triangle);
    }
    return result;
}

TEST(Refinement, CutsEveryTetrahedronIntoEightOfTheSameVolumeAndRegion) {
    const auto body = sample_body();
    const auto fine = refine(body);
    const auto coarse_volumes = tetrahedron_volumes(body.mesh);
    const auto volumes = tetrahedron_volumes(fine.mesh);
    ASSERT_EQ(volumes.size(), 8 * coarse_volumes.size());
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        EXPECT_NEAR(volumes[t], coarse_volumes[t / 8] / 8.0, 1e-12 * coarse_volumes[t / 8]);
        EXPECT_EQ(fine.mesh.region[t], body.mesh.region[t / 8]);
    }
    const auto before = region_volumes(body.mesh), after = region_volumes(fine.mesh);
    ASSERT_EQ(after.size(), 2u);
    for (int r = 0; r < 2; ++r)
        EXPECT_NEAR(after[r], before[r], 1e-13 * before[r]);
    EXPECT_EQ(fine.mesh.region_names, body.mesh.region_names);
    EXPECT_EQ(fine.materials.size(), body.materials.size());
    EXPECT_EQ(fine.name, body.name);
}

TEST(Refinement, KeepsTheNodesAndPutsTheMiddlesOfTheEdgesBehindThem) {
    const auto body = sample_body();
    const auto fine = refine(body);
    const auto edges = edge_table(body.mesh.tetrahedra).edges;
    ASSERT_EQ(fine.mesh.points.size(), body.mesh.points.size() + edges.size());
    for (int node = 0; node < body.mesh.num_nodes(); ++node)
        EXPECT_EQ(fine.mesh.points[node], body.mesh.points[node]);
    for (std::size_t e = 0; e < edges.size(); ++e) {
        const Vector3 middle = 0.5 * (body.mesh.points[edges[e][0]] + body.mesh.points[edges[e][1]]);
        EXPECT_EQ(fine.mesh.points[body.mesh.points.size() + e], middle);
    }
}

/// The outer faces of the fine tetrahedra are the carried boundary, outward: so there is no gap and no overlap inside.
TEST(Refinement, IsConforming) {
    auto body = sample_body();
    for (int level = 0; level < 2; ++level) {
        body = refine(body);
        const auto outer = with_first_node_least(outer_faces(body.mesh.tetrahedra));
        EXPECT_EQ(outer.size(), body.mesh.boundary_triangles.size());
        EXPECT_EQ(outer, with_first_node_least(body.mesh.boundary_triangles));
    }
}

TEST(Refinement, KeepsPatchesAndTheirAreas) {
    const auto body = sample_body();
    const auto fine = refine(body);
    ASSERT_EQ(fine.mesh.boundary_triangles.size(), 4 * body.mesh.boundary_triangles.size());
    EXPECT_EQ(fine.mesh.patch_names, body.mesh.patch_names);
    for (int f = 0; f < fine.mesh.num_boundary_triangles(); ++f) {
        EXPECT_EQ(fine.mesh.boundary_patch[f], body.mesh.boundary_patch[f / 4]);
        const Vector3 quarter = area_vector(body.mesh, f / 4) / 4.0;
        EXPECT_LT((area_vector(fine.mesh, f) - quarter).norm(), 1e-12 * quarter.norm());
    }
    const auto before = patch_area_vectors(body.mesh), after = patch_area_vectors(fine.mesh);
    for (std::size_t p = 0; p < before.size(); ++p)
        EXPECT_LT((after[p] - before[p]).norm(), 1e-13 * before[p].norm());
}

/// The worst tetrahedron gets somewhat worse at first; then the same few shapes come back.
TEST(Refinement, KeepsTheQualityBounded) {
    auto body = sample_body();
    std::vector<double> quality{least_quality(body.mesh)};
    for (int level = 0; level < 3; ++level) {
        body = refine(body);
        quality.push_back(least_quality(body.mesh));
    }
    for (const double refined : quality)
        EXPECT_GT(refined, 0.6 * quality[0]);
    EXPECT_NEAR(quality[3], quality[2], 1e-9);
}

/// Cut along a diagonal that is not the shortest, a regular tetrahedron would do no worse: it has three equal ones. A
/// stretched one shows the choice.
TEST(Refinement, CutsTheOctahedronAlongItsShortestDiagonal) {
    auto mesh = tests::regular_tetrahedron(1.0);
    for (auto &point : mesh.points)
        point.y() *= 2.0;
    // Opposite edges of this one are a distance apart in x, y and z; the diagonals have the lengths 1/sqrt 2 and
    // sqrt 2.
    const auto fine = refine(*tests::make_body(mesh, soft)).mesh;
    const auto edges = edge_table(fine.tetrahedra).edges;
    const auto is_long_diagonal = [&](const auto &edge) {
        return std::ranges::all_of(edge, [](int node) { return node >= 4; }) &&
               std::abs((fine.points[edge[0]] - fine.points[edge[1]]).norm() - std::sqrt(2.0)) < 1e-12;
    };
    EXPECT_TRUE(std::ranges::none_of(edges, is_long_diagonal));
    EXPECT_EQ(edges.size(), 25u); // 12 halves, 12 on the faces, 1 diagonal
}

TEST(Refinement, CarriesTheConditionsOverOnTheFacets) {
    const auto body = std::make_shared<const Body>(sample_body());
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
    tests::prescribe(load_case, body->mesh, "y_min", {nan, 0.001, nan});
    tests::pull(load_case, body->mesh, "x_max", {10.0, 20.0, 30.0});
    load_case.acceleration = {0.0, 0.0, -9.81};
    for (const auto &point : body->mesh.points)
        load_case.node_factor.push_back(1.0 + point.x());
    load_case.node_shift = body->mesh.points;
    const auto fine = refine(Problem{body, load_case});
    const auto same = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
    ASSERT_EQ(fine.load_case.num_facets(), fine.body->mesh.num_boundary_triangles());
    ASSERT_EQ(fine.load_case.value.size(), fine.body->mesh.boundary_triangles.size());
    for (int f = 0; f < fine.load_case.num_facets(); ++f) {
        EXPECT_EQ(fine.load_case.condition_on[f], load_case.condition_on[f / 4]);
        for (int i = 0; i < 3; ++i)
            EXPECT_TRUE(same(fine.load_case.value[f][i], load_case.value[f / 4][i]));
    }
    for (int node = 0; node < fine.body->mesh.num_nodes(); ++node)
        EXPECT_NEAR(fine.load_case.factor_at(node), 1.0 + fine.body->mesh.points[node].x(), 1e-15);
    ASSERT_EQ(fine.load_case.node_shift.size(), fine.body->mesh.points.size());
    for (int node = 0; node < fine.body->mesh.num_nodes(); ++node)
        EXPECT_LT((fine.load_case.node_shift[node] - fine.body->mesh.points[node]).norm(), 1e-15);
    EXPECT_EQ(fine.load_case.constraint_names(), load_case.constraint_names());
    EXPECT_EQ(fine.load_case.acceleration, load_case.acceleration);
    EXPECT_EQ(fine.load_case.name, load_case.name);
}

TEST(Refinement, RefusesABoundaryTriangleThatIsNotThere) {
    auto body = sample_body();
    body.mesh.boundary_triangles[0] = {0, 1, body.mesh.num_nodes() - 1};
    EXPECT_THROW(refine(body), std::invalid_argument);
}

} // namespace
} // namespace livermark::core
