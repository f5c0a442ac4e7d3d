#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <stdexcept>
#include <vector>

#include "core/local_refinement.hpp"
#include "core/observed_error.hpp"
#include "tests/fem_reference/verification/fem_test_bodies.hpp"
#include "tests/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

double volume(const core::TetraMesh &mesh) {
    const auto volumes = core::tetrahedron_volumes(mesh);
    return std::accumulate(volumes.begin(), volumes.end(), 0.0);
}

/// Of a triangle, however its nodes are turned.
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

/// What fits together has no outer faces but the parts of the boundary triangles: a face between two tetrahedra that
/// one of them cut differently would be one.
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
        EXPECT_EQ(refined.load_case.condition.size(), fine.boundary_triangles.size());
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
    for (const auto &nodes : problem.body->mesh.tetrahedra)
        if (std::ranges::any_of(nodes, [&](int node) { return is_rim[node]; })) {
            EXPECT_FALSE(kept.contains(nodes));
        }
}

/// Every part has the condition of its parent, so the loads are the same.
TEST(LocalRefinement, KeepsAreasOfConditions) {
    auto problem = pressed_box();
    problem.load_case.follows.assign(problem.load_case.condition.size(), 0);
    for (std::size_t f = 0; f < problem.load_case.follows.size(); f += 2)
        problem.load_case.follows[f] = 1;
    const auto refined = core::refine_at_rims(problem, 2);
    const auto areas = [](const core::Problem &of) {
        std::map<std::array<int, 3>, double> area;
        for (int f = 0; f < of.body->mesh.num_boundary_triangles(); ++f)
            area[{static_cast<int>(of.load_case.condition[f]), of.load_case.constraint[f],
                  static_cast<int>(of.load_case.follows[f])}] += core::area_vector(of.body->mesh, f).norm();
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
    const auto observed = core::observed_error(mesh, levels);
    EXPECT_NEAR(observed.order, 1.0, 0.01); // differences are relative to the finer one
    EXPECT_NEAR(observed.relative_l2, 0.002, 2e-5);
    EXPECT_NEAR(observed.energy, 0.002, 2e-5);
    EXPECT_NEAR(observed.reaction, 0.004, 4e-5);
    EXPECT_THROW(core::observed_error(mesh, std::span(levels).first(2)), std::invalid_argument);
}

core::ObservedMotionError observed_of_motions_off_by(const std::vector<double> &errors) {
    std::vector<core::History> levels;
    for (const double error : errors) {
        auto &history = levels.emplace_back();
        history.time = {0.0, 0.1, 0.2};
        for (const double amplitude : {1.0, 0.5, -0.7})
            history.displacement.emplace_back((1.0 + error) * amplitude, 0.0, 0.0);
    }
    return core::observed_motion_error(levels);
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
        return core::observed_error(mesh, levels);
    };
    const auto lucky = with_errors(0.1, 0.0101, 0.0001);
    EXPECT_NEAR(lucky.relative_l2, lucky.difference / 3.0, 1e-12);
    const auto stuck = with_errors(0.03, 0.02, 0.01);
    EXPECT_NEAR(stuck.relative_l2, 4.0 * stuck.difference, 1e-12);
}

} // namespace
} // namespace livermark
