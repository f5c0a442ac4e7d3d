#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <stdexcept>
#include <vector>

#include "core/error_norms.hpp"
#include "core/mesh/refinement.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/samples/covered_bodies.hpp"
#include "tests/samples/even_foundation.hpp"
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
    const auto tetrahedron_volume = tetrahedron_volumes(mesh);
    for (std::size_t t = 0; t < tetrahedron_volume.size(); ++t)
        volumes[mesh.region[t]] += tetrahedron_volume[t];
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
    load_case.foundation = tests::even_foundation({1, 4}, 1e5, true);
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
    EXPECT_EQ(fine.load_case.foundation.value().facets, (std::vector{4, 5, 6, 7, 16, 17, 18, 19}));
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

namespace livermark {
namespace {

using core::Vector3;

double volume(const core::TetraMesh &mesh) {
    const auto volumes = core::tetrahedron_volumes(mesh);
    return std::accumulate(volumes.begin(), volumes.end(), 0.0);
}

/// Nodes of a triangle from the least one on, however they were turned.
std::array<int, 3> turned(std::array<int, 3> nodes) {
    std::ranges::rotate(nodes, std::ranges::min_element(nodes));
    return nodes;
}

std::set<std::array<int, 3>> triangles(std::span<const std::array<int, 3>> all) {
    std::set<std::array<int, 3>> result;
    for (const auto &nodes : all)
        result.insert(turned(nodes));
    return result;
}

core::Problem pressed_box() {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.12, 0.08}, {4, 5, 3}), {1060.0, 5e3, 0.45});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
    tests::pull(load_case, body->mesh, "x_max", {10.0, 0.0, 0.0});
    return {body, std::move(load_case)};
}

/// A mesh that fits together has no outer faces but the parts of the boundary triangles: a face between two tetrahedra
/// that one of them cut differently would be one.
TEST(LocalRefinement, LeavesAMeshThatFitsTogether) {
    const auto problem = pressed_box();
    for (const int levels : {1, 2, 3}) {
        const auto refined = core::refine_at_rims(problem, levels);
        const auto &coarse = problem.body->mesh, &fine = refined.body->mesh;
        EXPECT_GT(fine.num_tetrahedra(), coarse.num_tetrahedra());
        EXPECT_EQ(triangles(core::outer_faces(fine.tetrahedra)), triangles(fine.boundary_triangles));
        EXPECT_NEAR(volume(fine), volume(coarse), 1e-14);
        EXPECT_GT(std::ranges::min(core::tetrahedron_volumes(fine)), 0.0);
        EXPECT_TRUE(std::equal(coarse.points.begin(), coarse.points.end(), fine.points.begin()));
        EXPECT_EQ(refined.load_case.num_facets(), fine.boundary_triangles.size());
    }
}

TEST(LocalRefinement, CutsAtTheRimsAndNowhereElse) {
    const auto problem = pressed_box();
    const auto is_rim = core::rim_nodes(problem.body->mesh, problem.load_case);
    for (int node = 0; node < problem.body->mesh.num_nodes(); ++node) {
        const auto &x = problem.body->mesh.points[node];
        const bool is_side = x.y() < 1e-9 || x.y() > 0.12 - 1e-9 || x.z() < 1e-9 || x.z() > 0.08 - 1e-9;
        EXPECT_EQ(is_rim[node], is_side && (x.x() < 1e-9 || x.x() > 0.1 - 1e-9)) << x.transpose();
    }
    const auto refined = core::refine_at_rims(problem, 1);
    std::set<std::array<int, 4>> kept(refined.body->mesh.tetrahedra.begin(), refined.body->mesh.tetrahedra.end());
    int num_at_rims = 0;
    for (const auto &nodes : problem.body->mesh.tetrahedra)
        if (std::ranges::any_of(nodes, [&](int node) { return is_rim[node]; })) {
            ++num_at_rims;
            EXPECT_FALSE(kept.contains(nodes));
        }
    EXPECT_GT(num_at_rims, 0);
    EXPECT_LT(num_at_rims, problem.body->mesh.num_tetrahedra());
}

TEST(LocalRefinement, CutsAtFurtherNodesAsWell) {
    const auto problem = pressed_box();
    const auto &mesh = problem.body->mesh;
    auto is_marked = core::rim_nodes(mesh, problem.load_case);
    std::vector<bool> is_further(mesh.points.size(), false);
    const auto further = std::ranges::find(is_marked, false) - is_marked.begin();
    is_marked[further] = is_further[further] = true;
    const auto refined = core::refine_at_rims_and(problem, is_further);
    const auto &fine = refined.problem.body->mesh.tetrahedra;
    const std::set<std::array<int, 4>> kept(fine.begin(), fine.end());
    for (const auto &nodes : mesh.tetrahedra)
        if (std::ranges::any_of(nodes, [&](int node) { return is_marked[node]; })) {
            EXPECT_FALSE(kept.contains(nodes));
        }
    is_further[further] = false;
    EXPECT_EQ(core::refine_at_rims_and(problem, is_further).problem.body->mesh.tetrahedra,
              core::refine_at_rims(problem).problem.body->mesh.tetrahedra);
    EXPECT_GT(fine.size(), core::refine_at_rims(problem).problem.body->mesh.tetrahedra.size());
}

TEST(LocalRefinement, CutsAtRimsAndBelowAPlaceThatIsSmallerThanAnEdge) {
    const auto problem = pressed_box();
    const core::InteriorPlace point{{0.05, 0.06, 0.08}, 1e-4};
    const auto num_at = [&](std::span<const core::InteriorPlace> places) {
        return core::refine_at_rims_and_near(problem, places, 1.5).problem.body->mesh.num_tetrahedra();
    };
    EXPECT_EQ(num_at({}), core::refine_at_rims(problem).problem.body->mesh.num_tetrahedra());
    EXPECT_GT(num_at({&point, 1}), num_at({}));
}

TEST(LocalRefinement, KeepsWhatIsPrescribedLinearBetweenNodes) {
    auto problem = pressed_box();
    for (const auto &point : problem.body->mesh.points)
        problem.load_case.node_factor.push_back(1.0 + point.x() - 2.0 * point.z());
    problem.load_case.node_shift = problem.body->mesh.points;
    const auto refined = core::refine_at_rims(problem, 2);
    ASSERT_EQ(refined.load_case.node_factor.size(), refined.body->mesh.points.size());
    for (int node = 0; node < refined.body->mesh.num_nodes(); ++node) {
        const auto &point = refined.body->mesh.points[node];
        EXPECT_NEAR(refined.load_case.factor_at(node), 1.0 + point.x() - 2.0 * point.z(), 1e-15);
        EXPECT_LT((refined.load_case.node_shift[node] - point).norm(), 1e-15);
    }
}

/// Every part has the condition of its parent, so the loads are the same.
TEST(LocalRefinement, KeepsAreasOfConditions) {
    auto problem = pressed_box();
    auto &load_case = problem.load_case;
    load_case.conditions.push_back({"end", core::ConditionKind::pressure});
    for (int f = 0; f < load_case.num_facets(); f += 2)
        if (load_case.is_loaded(f))
            load_case.condition_on[f] = static_cast<int>(load_case.conditions.size()) - 1;
    std::vector<int> below;
    for (int f = 0; f < load_case.num_facets(); f += 3)
        below.push_back(f);
    load_case.foundation = tests::even_foundation(below, 1e5, false);
    const auto refined = core::refine_at_rims(problem, 2);
    EXPECT_GT(refined.load_case.num_facets(), load_case.num_facets());
    const auto areas = [](const core::Problem &of) {
        std::map<int, double> area;
        for (int f = 0; f < of.body->mesh.num_boundary_triangles(); ++f)
            area[of.load_case.condition_on[f]] += core::area_vector(of.body->mesh, f).norm();
        constexpr int foundation_key = -2; // beside the numbers of conditions
        for (const int f : of.load_case.foundation.value().facets)
            area[foundation_key] += core::area_vector(of.body->mesh, f).norm();
        return area;
    };
    const auto before = areas(problem), after = areas(refined);
    ASSERT_EQ(before.size(), after.size());
    for (const auto &[key, area] : before)
        EXPECT_NEAR(after.at(key), area, 1e-14);
}

TEST(ObservedError, IsExactForErrorsThatShrinkByOneFactor) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
    std::vector<core::Solution> levels;
    for (const double error : {0.008, 0.004, 0.002}) {
        auto &solution = levels.emplace_back();
        solution.displacement.assign(mesh.points.size(), Vector3(1.0 + error, 0.0, 0.0));
        solution.reaction = {{0.0, 1.0 + 2.0 * error, 0.0}};
        solution.strain_energy = 1.0 - error;
    }
    const auto observed = core::observed_error(mesh, {}, levels);
    EXPECT_NEAR(observed.order, 1.0, 0.01); // differences are relative to the finer one
    EXPECT_NEAR(observed.relative_l2, 0.002, 2e-5);
    EXPECT_NEAR(observed.energy, 0.002, 2e-5);
    EXPECT_NEAR(observed.reaction, 0.004, 4e-5);
    EXPECT_THROW(core::observed_error(mesh, {}, std::span(levels).first(2)), std::invalid_argument);
}

core::ObservedMotionError observed_of_motions_off_by(const std::vector<double> &errors) {
    std::vector<core::History> levels;
    for (const double error : errors) {
        auto &history = levels.emplace_back();
        history.time = {0.0, 0.1, 0.2};
        for (const double amplitude : {1.0, 0.5, -0.7})
            history.displacement.emplace_back((1.0 + error) * amplitude, 0.0, 0.0);
    }
    return core::observed_motion_error(levels, core::first_order_factor);
}

TEST(ObservedError, OfMotionIsExactForErrorsThatHalve) {
    const auto observed = observed_of_motions_off_by({0.016, 0.008, 0.004});
    EXPECT_NEAR(observed.order, 1.0, 0.01);
    EXPECT_NEAR(observed.relative_l2, 0.004, 5e-5);
    EXPECT_NEAR(observed.difference, 0.004, 5e-5);
    EXPECT_THROW(observed_of_motions_off_by({0.016, 0.008}), std::invalid_argument);
}

TEST(ObservedError, OfMotionBelievesNoOrderBetterThanTheFirst) {
    const auto lucky = observed_of_motions_off_by({0.016, 0.004, 0.001});
    EXPECT_NEAR(lucky.order, 2.0, 0.01);
    EXPECT_EQ(lucky.relative_l2, lucky.difference);
}

TEST(ObservedError, BelievesNoFactorThatIsTooGoodOrNone) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
    const auto with_errors = [&](double first, double second, double third) {
        std::vector<core::Solution> levels;
        for (const double error : {first, second, third}) {
            auto &solution = levels.emplace_back();
            solution.displacement.assign(mesh.points.size(), Vector3(1.0 + error, 0.0, 0.0));
            solution.reaction = {{0.0, 1.0, 0.0}};
            solution.strain_energy = 1.0;
        }
        return core::observed_error(mesh, {}, levels);
    };
    const auto lucky = with_errors(0.1, 0.0101, 0.0001);
    EXPECT_NEAR(lucky.relative_l2, lucky.difference / 3.0, 1e-12);
    const auto stuck = with_errors(0.03, 0.02, 0.01);
    EXPECT_NEAR(stuck.relative_l2, 4.0 * stuck.difference, 1e-12);
}

/// Energies and reactions that hardly change any more may still lack what no mesh has refined.
TEST(ObservedError, OfEnergyAndReactionsBelievesNoOrderBetterThanTheFirst) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
    std::vector<core::Solution> levels;
    for (const double error : {0.1, 0.01, 0.0}) {
        auto &solution = levels.emplace_back();
        solution.displacement.assign(mesh.points.size(), Vector3(1.0 + 0.1 * std::sqrt(error), 0.0, 0.0));
        solution.reaction = {{0.0, 1.0 + error, 0.0}};
        solution.strain_energy = 1.0 - error;
    }
    const auto observed = core::observed_error(mesh, {}, levels);
    EXPECT_NEAR(observed.energy, 0.01, 1e-12);
    EXPECT_NEAR(observed.reaction, 0.01, 1e-12);
    // A slow displacement does not make them slow.
    levels[0].displacement[0].x() = 2.0;
    EXPECT_EQ(core::observed_error(mesh, {}, levels).energy, observed.energy);
}

TEST(ObservedError, OfANumberIsThatOfTheFirstOrderAtBest) {
    EXPECT_NEAR(core::observed_error(std::vector{1.4, 1.2, 1.1}), 0.1, 1e-12);      // the first order
    EXPECT_NEAR(core::observed_error(std::vector{9.0, 1.4, 1.2, 1.1}), 0.1, 1e-12); // the last three count
    EXPECT_NEAR(core::observed_error(std::vector{2.0, 1.01, 1.0}), 0.01, 1e-12);    // luck
    EXPECT_NEAR(core::observed_error(std::vector{1.3, 1.4, 1.3}), 0.4, 1e-12);      // no order at all
    EXPECT_EQ(core::observed_error(std::vector{1.0, 1.0, 1.0}), 0.0);
    EXPECT_THROW(core::observed_error(std::vector{1.0, 1.0}), std::invalid_argument);
}

/// Solutions 1 + error in x, with a path of one point at half of it.
std::vector<core::Solution> with_errors(const core::TetraMesh &mesh, std::span<const double> errors) {
    std::vector<core::Solution> levels;
    for (const double error : errors) {
        auto &solution = levels.emplace_back();
        solution.displacement.assign(mesh.points.size(), Vector3(1.0 + error, 0.0, 0.0));
        solution.reaction = {{0.0, 1.0 + 2.0 * error, 0.0}};
        solution.strain_energy = 1.0 - error;
        auto &point = solution.path.emplace_back();
        point.displacement.assign(mesh.points.size(),
                                  Eigen::Vector3f(static_cast<float>(0.5 + 0.5 * error), 0.0F, 0.0F));
        point.reaction = {{0.0, 0.5 + error, 0.0}};
        point.strain_energy = 0.25 - 0.25 * error;
    }
    return levels;
}

TEST(Extrapolation, IsExactForErrorsThatShrinkByOneFactor) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
    const auto levels = with_errors(mesh, std::array{0.016, 0.008, 0.004, 0.002});
    const auto limit = core::extrapolated(mesh, {}, levels);
    constexpr double tolerance = 3e-5; // the factor is that of relative differences
    for (const auto &displacement : limit.displacement)
        EXPECT_NEAR(displacement.x(), 1.0, tolerance);
    EXPECT_NEAR(limit.reaction[0].y(), 1.0, 1e-12);
    EXPECT_NEAR(limit.strain_energy, 1.0, 1e-12);
    EXPECT_NEAR(limit.path[0].displacement[0].x(), 0.5, tolerance);
    EXPECT_NEAR(limit.path[0].reaction[0].y(), 0.5, 1e-12);
    EXPECT_NEAR(limit.path[0].strain_energy, 0.25, 1e-12);
    EXPECT_NEAR(limit.observed_error.value().relative_l2, core::doubt * 0.002, tolerance);
}

TEST(Extrapolation, LeavesAloneWhatHasNoCleanOrder) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
    for (const auto &errors : {std::array{0.1, 0.0101, 0.0001}, std::array{0.03, 0.02, 0.01}}) {
        const auto levels = with_errors(mesh, errors);
        const auto limit = core::extrapolated(mesh, {}, levels);
        EXPECT_EQ(limit.displacement, levels.back().displacement);
        EXPECT_EQ(limit.reaction, levels.back().reaction);
        EXPECT_EQ(limit.strain_energy, levels.back().strain_energy);
        EXPECT_EQ(limit.observed_error->relative_l2, core::observed_error(mesh, {}, levels).relative_l2);
    }
}

/// Solutions of traction alone have reactions that do not depend on the mesh.
TEST(Extrapolation, LeavesReactionsThatDoNotChange) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
    auto levels = with_errors(mesh, std::array{0.008, 0.004, 0.002});
    for (auto &solution : levels)
        solution.reaction = {{0.0, 1.0, 0.0}};
    EXPECT_EQ(core::extrapolated(mesh, {}, levels).reaction, levels.back().reaction);
}

TEST(LocalRefinement, NamesTheTetrahedronThatEachIsAPartOf) {
    const auto problem = pressed_box();
    const auto refined = core::refine_at_rims(problem);
    const auto &coarse = problem.body->mesh, &fine = refined.problem.body->mesh;
    ASSERT_EQ(refined.parent_tetrahedron.size(), fine.tetrahedra.size());
    std::vector<double> volume_of_parts(coarse.tetrahedra.size(), 0.0);
    const auto volumes = core::tetrahedron_volumes(fine);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        volume_of_parts[refined.parent_tetrahedron[t]] += volumes[t];
    const auto expected = core::tetrahedron_volumes(coarse);
    for (std::size_t t = 0; t < expected.size(); ++t)
        EXPECT_NEAR(volume_of_parts[t], expected[t], 1e-12 * expected[t]);
}

namespace {

/// Largest distance of the covered nodes of an eighth of a ball from the sphere, on its capsule and on its mesh, over
/// the radius. Normals at the rim of a capsule know one side, so nodes near it are not looked at.
std::array<double, 2> distances_from_sphere(const core::Body &body, double radius) {
    const auto surface = core::capsule_surface(body);
    std::array<double, 2> largest{};
    for (int f = 0; f < body.mesh.num_boundary_triangles(); ++f)
        for (const int node : body.mesh.boundary_triangles[f])
            if (core::Capsule::covers(body.mesh, f)) {
                const core::Vector3 &point = body.mesh.points[node];
                if (point.minCoeff() < 0.4 * radius)
                    continue;
                largest[0] = std::max(largest[0], std::abs((point + surface->offset[node]).norm() / radius - 1.0));
                largest[1] = std::max(largest[1], std::abs(point.norm() / radius - 1.0));
            }
    return largest;
}

} // namespace

/// A mesh that is refined stays a polyhedron, and the capsule on it is as round as the ball was.
TEST(Refinement, KeepsACapsuleRound) {
    constexpr double radius = 0.03;
    const auto problem = tests::covered::blown_up_ball(radius, 4, core::soft, 1.0, core::ConditionKind::traction);
    const auto once = core::refine(*problem.body), again = core::refine(once);
    for (const auto *const body : {&once, &again}) {
        const auto [capsule, mesh] = distances_from_sphere(*body, radius);
        EXPECT_LT(capsule, 0.1 * mesh);
    }
    const auto edges = core::edge_table(problem.body->mesh.tetrahedra).edges;
    const auto bisected = core::bisect(*problem.body, {edges.begin(), edges.end()});
    const auto [capsule, mesh] = distances_from_sphere(bisected.body, radius);
    EXPECT_LT(capsule, 0.1 * mesh);
}

/// A box has edges, at which a capsule is not round.
TEST(Refinement, KeepsACapsuleOnABoxFlat) {
    auto box = core::sample_body();
    box.capsule = tests::covered::capsule;
    const auto refined = core::refine(box);
    for (const auto &offset : core::capsule_surface(refined)->offset)
        EXPECT_LT(offset.norm(), 1e-15);
}

} // namespace
} // namespace livermark
