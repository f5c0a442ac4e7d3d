#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <vector>

#include "interactive/colouring.hpp"
#include "interactive/kernels/fans.hpp"
#include "interactive/method.hpp"
#include "tests/interactive/both_precisions.hpp"

namespace livermark {
namespace {

using interactive::Field;
using tests::distance_over_motion;
using tests::Frames;
using tests::uneven_scene;

/// Vertex block descent in single precision, beside that in double precision.
struct DescentSteps : testing::Test {
    const interactive::Method &method = interactive::find_method("vertex_block_descent");
};

TEST_F(DescentSteps, MoveAsInDoublePrecision) {
    for (const auto &frames : {Frames{7, 1}, Frames{7, 10}, Frames{1, 3}, Frames{1, 20}})
        for (const bool is_constrained : {true, false}) {
            const double distance = distance_over_motion(method, uneven_scene({5, 3, 3}, is_constrained, 5.0), frames);
            EXPECT_LT(distance, 1e-4) << frames.steps << " " << frames.iterations << " " << is_constrained;
            EXPECT_GT(distance, 0.0) << "both are the same code";
        }
}

TEST_F(DescentSteps, MoveAsInDoublePrecisionWithAnyPadding) {
    for (const auto &scene : tests::scenes_of_any_padding())
        EXPECT_LT(distance_over_motion(method, scene, {7, 4}), 1e-4) << scene.node_mass.size();
}

TEST_F(DescentSteps, GiveTheForcesOfDoublePrecision) {
    const auto [single, in_double] = tests::dragged_in_both(method, uneven_scene({5, 3, 3}, true, 5.0), {7, 1});
    const Field forces = in_double->elastic_forces(), reactions = in_double->reactions();
    EXPECT_LT((single->elastic_forces() - forces).norm(), 2e-3 * forces.norm());
    EXPECT_LT((single->reactions() - reactions).norm(), 2e-3 * reactions.norm());
    EXPECT_GT(reactions.norm(), 0.01);
}

TEST_F(DescentSteps, StayAtRestToTheLastBit) {
    const auto simulation = method.prepare(uneven_scene({3, 2, 1}, true));
    const Field rest = simulation->positions();
    for (int i = 0; i < 5; ++i)
        simulation->step(2e-3, 10);
    EXPECT_EQ(simulation->positions(), rest);
    EXPECT_EQ(simulation->velocities(), Field::Zero(3, rest.cols()));
}

TEST_F(DescentSteps, PutConstrainedNodesExactlyWhereTheyAreToldToBe) {
    tests::expect_constrained_nodes_at_targets(method);
}

TEST_F(DescentSteps, ConserveMomentumOnceTheyHaveConverged) {
    tests::expect_momentum_to_stay(method, 300, 1e-4);
}

TEST_F(DescentSteps, AreTheSameOnAnyVectorsThatMultiplyAndAddAtOnce) {
    tests::expect_the_same_on_any_vectors(method, {2, 5}, 1e-4);
}

/// With the same rho for any number of iterations, two to four of them in a frame diverged.
TEST_F(DescentSteps, DoNotGrowWhereIterationsAreFew) {
    for (int iterations = 1; iterations <= 12; ++iterations) {
        const auto simulation = method.prepare(uneven_scene({5, 3, 3}, true));
        const Field rest = simulation->positions();
        simulation->set_state(rest + tests::noise(rest.cols(), 1e-4, 2), Field::Zero(3, rest.cols()));
        for (int i = 0; i < 200; ++i)
            simulation->step(interactive::frame_time, iterations);
        EXPECT_LT((simulation->positions() - rest).cwiseAbs().maxCoeff(), 1e-4) << iterations;
    }
}

TEST(Chebyshev, LeavesOfEachPartWhatItsPolynomialSays) {
    const double rho = 0.9;
    for (const double factor : {-0.9, -0.3, 0.0, 0.5, 0.9, 0.99}) {
        double x = 1.0, older = 0.0, weight = 1.0;
        for (int n = 1; n <= 12; ++n) {
            weight = interactive::chebyshev_weight(n, weight, rho);
            const double next = n == 1 ? factor * x : weight * (factor * x - older) + older;
            older = x;
            x = next;
            const double s = factor / rho;
            const double of_s = std::abs(s) <= 1.0 ? std::cos(n * std::acos(s)) : std::cosh(n * std::acosh(s));
            EXPECT_NEAR(x, of_s / std::cosh(n * std::acosh(1.0 / rho)), 1e-12) << factor << " " << n;
        }
    }
}

TEST(Chebyshev, LeavesAtMostATenthOfWhatIsStiff) {
    for (int n = 2; n < 40; ++n) {
        const double rho = interactive::chebyshev_rho(n);
        EXPECT_LE(1.0 / std::cosh(n * std::acosh(1.0 / rho)), 0.1 + 1e-12) << n;
        EXPECT_LE(interactive::chebyshev_rho(n - 1), rho);
        EXPECT_LE(rho, 0.95);
    }
}

/// What a kernel makes of strips: the triangles in their order.
std::vector<std::set<int>> triangles_of(const std::vector<interactive::kernels::StripNode> &strips) {
    std::vector<std::set<int>> triangles;
    std::array<int, 3> at{-1, -1, -1};
    for (const auto &[node, triangle, keeps_first] : strips) {
        at = {keeps_first ? at[0] : at[1], at[2], node};
        if (triangle >= 0)
            triangles.emplace_back(at.begin(), at.end());
    }
    return triangles;
}

void expect_strips_of(const std::vector<std::array<int, 3>> &triangles, std::size_t num_strips) {
    const auto strips = interactive::kernels::cut_into_strips(triangles);
    EXPECT_EQ(strips.size(), triangles.size() + 2 * num_strips);
    const auto found = triangles_of(strips);
    ASSERT_EQ(found.size(), triangles.size());
    std::set<int> seen;
    std::size_t k = 0;
    for (const auto &entry : strips)
        if (entry.triangle >= 0) {
            EXPECT_TRUE(seen.insert(entry.triangle).second);
            const auto &nodes = triangles[entry.triangle];
            EXPECT_EQ(found[k++], std::set<int>(nodes.begin(), nodes.end()));
        }
}

TEST(Strips, GoRoundAClosedSurfaceAtOnce) {
    expect_strips_of({{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {5, 1, 2}, {5, 2, 3}, {5, 3, 4}, {5, 4, 1}}, 1);
}

TEST(Strips, BeginAnewWhereTrianglesShareNoEdge) {
    expect_strips_of({{0, 1, 2}, {2, 3, 4}, {1, 2, 5}}, 2);
    expect_strips_of({{7, 8, 9}}, 1);
    EXPECT_TRUE(interactive::kernels::cut_into_strips({}).empty());
}

TEST(Strips, HaveNextToOneNodeForEachTetrahedronAroundANode) {
    const auto mesh = tests::box_mesh({0.06, 0.03, 0.03}, {5, 3, 3});
    std::size_t num_corners = 0, num_nodes = 0;
    for (int node = 0; node < mesh.num_nodes(); ++node) {
        std::vector<std::array<int, 3>> facets;
        for (auto nodes : mesh.tetrahedra) {
            const auto at = std::ranges::find(nodes, node);
            if (at == nodes.end())
                continue;
            std::iter_swap(at, nodes.begin());
            facets.push_back({nodes[1], nodes[2], nodes[3]});
        }
        const auto strips = interactive::kernels::cut_into_strips(facets);
        EXPECT_EQ(triangles_of(strips).size(), facets.size());
        num_corners += facets.size();
        num_nodes += strips.size();
    }
    EXPECT_LT(static_cast<double>(num_nodes), 1.25 * static_cast<double>(num_corners));
}

} // namespace
} // namespace livermark
