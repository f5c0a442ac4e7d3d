#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "core/load_case.hpp"
#include "core/mesh/refinement.hpp"
#include "core/tool/tool_motion.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/samples/test_meshes.hpp"
#include "tests/samples/tool_block.hpp"

namespace livermark {
namespace {

using core::Vector3;

const core::RoundLoad tool{{0.05, 0.04, 0.1}, 0.03};

/// A box that the tool presses from above.
core::Problem box_under_a_tool() {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.1, 0.1}, {3, 4, 3}), {1000.0, 2000.0, 0.45});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "z_min", Vector3::Zero());
    tests::pull(load_case, body->mesh, "z_max", {0.0, 0.0, -100.0});
    load_case.conditions.back().round = tool;
    for (int f = 0; f < body->mesh.num_boundary_triangles(); ++f)
        if (load_case.is_loaded(f))
            load_case.value[f] *= core::mean_height(tool, core::corners_of(body->mesh, f));
    return {body, load_case};
}

/// Forces on corners have the integrals of linear functions: the force, and its moment about the corners.
TEST(RoundLoad, PartsHaveForceAndMomentOfTheTraction) {
    const core::Corners corners{Vector3(0.05, 0.04, 0.1), Vector3(0.09, 0.05, 0.1), Vector3(0.04, 0.09, 0.1)};
    const auto linear = core::linear_parts(&tool, corners);
    const auto quadratic = core::quadratic_parts(&tool, corners);
    EXPECT_NEAR(std::accumulate(linear.begin(), linear.end(), 0.0), 1.0, 1e-12);
    EXPECT_NEAR(std::accumulate(quadratic.begin(), quadratic.end(), 0.0), 1.0, 1e-12);
    EXPECT_GT(linear[0], linear[1]); // the middle of the tool is at the first corner
    EXPECT_GT(linear[0], linear[2]);
    // Linear functions are quadratic ones, too: a corner has half of the sides that end there.
    for (std::size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(quadratic[k] + 0.5 * (quadratic[3 + k] + quadratic[3 + (k + 2) % 3]), linear[k], 1e-12);
}

TEST(RoundLoad, IsEvenWhereThereIsNoTool) {
    const core::Corners corners{Vector3(0.0, 0.0, 0.0), Vector3(1.0, 0.0, 0.0), Vector3(0.0, 1.0, 0.0)};
    for (const auto *load : {static_cast<const core::RoundLoad *>(nullptr), &tool}) { // which is elsewhere
        const core::Corners away{corners[0] + Vector3(1.0, 1.0, 1.0), corners[1] + Vector3(1.0, 1.0, 1.0),
                                 corners[2] + Vector3(1.0, 1.0, 1.0)};
        EXPECT_EQ(core::linear_parts(load, away), (std::array<double, 3>{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}));
        EXPECT_EQ(core::quadratic_parts(load, away),
                  (std::array<double, 6>{0.0, 0.0, 0.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}));
    }
}

/// The force, and that on linear functions: of each node the corners' parts times its place.
std::array<Vector3, 2> force_and_moment(const core::Problem &problem) {
    std::array<Vector3, 2> sum{Vector3::Zero(), Vector3::Zero()};
    const auto &[body, load_case] = problem;
    for (int f = 0; f < body->mesh.num_boundary_triangles(); ++f) {
        if (!load_case.is_loaded(f))
            continue;
        const Vector3 force = core::area_vector(body->mesh, f).norm() * load_case.value[f];
        const auto corners = core::corners_of(body->mesh, f);
        const auto parts = core::linear_parts(load_case.round_load_on(f), corners);
        sum[0] += force;
        for (std::size_t k = 0; k < 3; ++k)
            sum[1] += parts[k] * force.norm() * corners[k];
    }
    return sum;
}

/// The same load on a finer mesh of the same body.
TEST(RoundLoad, StaysWhereItIsWhenTheMeshIsRefined) {
    const auto problem = box_under_a_tool();
    const auto [force, moment] = force_and_moment(problem);
    ASSERT_LT(force.z(), 0.0);
    for (const auto &fine : {core::refine(problem), core::refine_at_rims(problem, 2)}) {
        ASSERT_GT(fine.body->mesh.num_boundary_triangles(), problem.body->mesh.num_boundary_triangles());
        const auto [fine_force, fine_moment] = force_and_moment(fine);
        EXPECT_LT((fine_force - force).norm(), 1e-12 * force.norm());
        EXPECT_LT((fine_moment - moment).norm(), 1e-4 * force.norm() * tool.radius);
        // On each part the traction has the mean of the tool, as on the whole.
        double most = 0.0;
        for (int f = 0; f < fine.body->mesh.num_boundary_triangles(); ++f)
            if (fine.load_case.round_load_on(f)) {
                const double height = core::mean_height(tool, core::corners_of(fine.body->mesh, f));
                most = std::max(most, std::abs(fine.load_case.value[f].z() + 100.0 * height));
            }
        EXPECT_LT(most, 0.5); // of 100 Pa; both means are sums over small triangles
    }
}

/// @return the longest edge of each tetrahedron [m]
std::vector<double> longest_edges(const core::TetraMesh &mesh) {
    std::vector<double> longest;
    for (const auto &nodes : mesh.tetrahedra) {
        longest.push_back(0.0);
        for (const auto &[i, j] : core::tetrahedron_edges)
            longest.back() = std::max(longest.back(), (mesh.points[nodes[i]] - mesh.points[nodes[j]]).norm());
    }
    return longest;
}

bool is_below_the_tool(const core::TetraMesh &mesh, const std::array<int, 4> &nodes) {
    const auto &[a, b, c, d] = nodes;
    const Vector3 centroid = 0.25 * (mesh.points[a] + mesh.points[b] + mesh.points[c] + mesh.points[d]);
    return (centroid - tool.middle).norm() < tool.radius;
}

TEST(RefinementBelowTools, EndsAtAPartOfTheRadius) {
    auto problem = box_under_a_tool();
    const auto longest = [&] {
        const auto edges = longest_edges(problem.body->mesh);
        double longest_below = 0.0;
        for (std::size_t t = 0; t < edges.size(); ++t)
            if (is_below_the_tool(problem.body->mesh, problem.body->mesh.tetrahedra[t]))
                longest_below = std::max(longest_below, edges[t]);
        return longest_below;
    };
    const double most = core::longest_edge_below_tools * tool.radius;
    ASSERT_GT(longest(), 2.0 * most);
    for (int level = 0; level < 4; ++level)
        problem = core::refine_at_rims_and_tools(problem).problem;
    EXPECT_LE(longest(), most);
    const auto &mesh = problem.body->mesh;
    const auto again = core::refine_at_rims_and_tools(problem);
    std::vector<int> num_parts(mesh.tetrahedra.size(), 0);
    for (const int parent : again.parent_tetrahedron)
        ++num_parts[parent];
    for (std::size_t t = 0; t < num_parts.size(); ++t)
        if (is_below_the_tool(mesh, mesh.tetrahedra[t])) {
            EXPECT_EQ(num_parts[t], 1); // away from the constrained surface nothing is cut any more
        }
}

TEST(RefinementBelowTools, LeavesAMeshThatFitsTogether) {
    auto problem = box_under_a_tool();
    for (int level = 0; level < 3; ++level)
        problem = core::refine_at_rims_and_tools(problem).problem;
    const auto sorted = [](std::vector<std::array<int, 3>> triangles) {
        for (auto &nodes : triangles)
            std::ranges::sort(nodes);
        std::ranges::sort(triangles);
        return triangles;
    };
    EXPECT_EQ(sorted(core::outer_faces(problem.body->mesh.tetrahedra)), sorted(problem.body->mesh.boundary_triangles));
    EXPECT_GT(std::ranges::min(core::tetrahedron_volumes(problem.body->mesh)), 0.0);
}

/// Facets are pressed as far as the disc touches them. Where they end there is no pressure any more, so no rim.
TEST(RefinementBelowTools, TakesTheOutlineOfPressedFacetsForNoRim) {
    const auto problem = box_under_a_tool();
    const auto &mesh = problem.body->mesh;
    const auto top_corners_cut = [&](const core::BisectedProblem &refined) {
        std::vector<int> num_parts(mesh.tetrahedra.size(), 0);
        for (const int parent : refined.parent_tetrahedron)
            ++num_parts[parent];
        int num_cut = 0;
        for (std::size_t t = 0; t < num_parts.size(); ++t)
            for (const int node : mesh.tetrahedra[t])
                if ((mesh.points[node] - Vector3(0.1, 0.1, 0.1)).norm() < 1e-9 && num_parts[t] == 8)
                    ++num_cut;
        return num_cut;
    };
    EXPECT_GT(top_corners_cut(core::refine_at_rims(problem)), 0);
    constexpr double any_length_will_do = 100.0;
    EXPECT_EQ(top_corners_cut(core::refine_at_rims_and_tools(problem, any_length_will_do)), 0);
}

TEST(ToolMotion, BeginsAndEndsItsWaysAtRestAndWithoutAJerk) {
    constexpr double h = 1e-4;
    EXPECT_EQ(core::smooth_step(-1.0, 0.0, 2.0), 0.0);
    EXPECT_EQ(core::smooth_step(3.0, 0.0, 2.0), 1.0);
    EXPECT_DOUBLE_EQ(core::smooth_step(1.0, 0.0, 2.0), 0.5);
    for (const double end : {0.0, 2.0}) {
        const double here = core::smooth_step(end, 0.0, 2.0);
        EXPECT_NEAR(core::smooth_step(end + h, 0.0, 2.0), here, 2e-12); // velocity and acceleration vanish
        EXPECT_NEAR(core::smooth_step(end - h, 0.0, 2.0), here, 2e-12);
    }
}

TEST(ToolMotion, LetsGoOfItsPlaceAlone) {
    const auto problem = tests::tool_block();
    const auto free = core::let_go(problem.load_case);
    int num_free = 0;
    for (int f = 0; f < free.num_facets(); ++f) {
        const bool is_tool = problem.load_case.constraint_on(f) == 1;
        EXPECT_EQ(free.condition_on[f], is_tool ? -1 : problem.load_case.condition_on[f]);
        num_free += is_tool ? 1 : 0;
    }
    EXPECT_EQ(num_free, 8);
    EXPECT_EQ(core::last_record_held(*free.tool), 11); // at 0.22 s, in frames of 0.02 s
}

TEST(ToolMotion, SlidesWithAllOfItsPlace) {
    auto problem = tests::tool_block();
    problem.load_case.node_factor.assign(problem.body->mesh.points.size(), 0.5);
    const auto slid = core::with_slide(problem.load_case);
    EXPECT_TRUE(slid.node_factor.empty());
    int num_slid = 0;
    for (int f = 0; f < slid.num_facets(); ++f)
        if (slid.constraint_on(f) == 1) {
            ++num_slid;
            EXPECT_EQ(slid.value[f], problem.load_case.tool->slide);
        }
    EXPECT_EQ(num_slid, 8); // two for each of 2 x 2 bricks
}

/// Two nodes' worth of motion: everything is k times the reference.
core::ToolHistory history_of(const core::Problem &problem, double factor) {
    core::ToolHistory history;
    for (int k = 0; k <= problem.load_case.tool->num_frames; ++k) {
        history.time.push_back(k * problem.load_case.tool->frame_interval);
        history.force.emplace_back(factor * k, 0.0, 0.0);
        if (core::ToolHistory::has_field(k))
            for (std::size_t i = 0; i < problem.body->mesh.points.size(); ++i)
                history.displacement.emplace_back(0.0F, static_cast<float>(factor * k), 0.0F);
    }
    return history;
}

TEST(ToolErrors, AreRelativeToTheReferenceInEachPartOfTheMotion) {
    const auto problem = tests::tool_block();
    const auto reference = history_of(problem, 1.0);
    auto other = history_of(problem, 1.25);
    const auto errors = core::compare(problem.body->mesh, *problem.load_case.tool, other, reference);
    EXPECT_NEAR(errors.contact, 0.25, 1e-6);
    EXPECT_NEAR(errors.after, 0.25, 1e-6);
    EXPECT_NEAR(errors.force, 0.25, 1e-12);
    ASSERT_EQ(errors.over_time.size(), 4U);
    EXPECT_NEAR(errors.over_time.back(), 0.25, 1e-6);
    EXPECT_EQ(errors.over_time.front(), 0.0);
    other.displacement.back().x() = NAN;
    EXPECT_TRUE(std::isnan(core::compare(problem.body->mesh, *problem.load_case.tool, other, reference).after));
    other.force.pop_back();
    EXPECT_THROW(core::compare(problem.body->mesh, *problem.load_case.tool, other, reference), std::invalid_argument);
}

} // namespace
} // namespace livermark
