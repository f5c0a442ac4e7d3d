#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <vector>

#include "interactive/kernels/orders.hpp"
#include "tests/interactive/moving_scene.hpp"

namespace livermark {
namespace {

std::vector<std::vector<int>> tetrahedra_of_the_bar() {
    std::vector<std::vector<int>> sets;
    const auto body = tests::soft_bar();
    for (const auto &nodes : body->mesh.tetrahedra)
        sets.emplace_back(nodes.begin(), nodes.end());
    return sets;
}

TEST(Colouring, GivesSetsThatShareANodeDifferentColours) {
    const auto sets = tetrahedra_of_the_bar();
    const auto colouring = interactive::colour_sets(sets, tests::soft_bar()->mesh.num_nodes());
    ASSERT_EQ(colouring.order.size(), sets.size());
    EXPECT_EQ(std::set<int>(colouring.order.begin(), colouring.order.end()).size(), sets.size());
    for (int c = 0; c < colouring.num_colours(); ++c) {
        std::set<int> nodes;
        for (int k = colouring.offsets[c]; k < colouring.offsets[c + 1]; ++k)
            for (const int node : sets[colouring.order[k]])
                EXPECT_TRUE(nodes.insert(node).second) << "node " << node << " twice in colour " << c;
    }
}

TEST(Colouring, GivesNodesOfOneSetDifferentColours) {
    const auto sets = tetrahedra_of_the_bar();
    const auto colouring = interactive::colour_nodes(sets, tests::soft_bar()->mesh.num_nodes());
    std::vector<int> colour(tests::soft_bar()->mesh.num_nodes(), -1);
    for (int c = 0; c < colouring.num_colours(); ++c)
        for (int k = colouring.offsets[c]; k < colouring.offsets[c + 1]; ++k)
            colour[colouring.order[k]] = c;
    EXPECT_EQ(std::ranges::count(colour, -1), 0);
    for (const auto &nodes : sets)
        for (const int a : nodes)
            for (const int b : nodes)
                EXPECT_TRUE(a == b || colour[a] != colour[b]);
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
            const double polynomial = std::abs(s) <= 1.0 ? std::cos(n * std::acos(s)) : std::cosh(n * std::acosh(s));
            EXPECT_NEAR(x, polynomial / std::cosh(n * std::acosh(1.0 / rho)), 1e-12) << factor << " " << n;
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

/// The triangles that a kernel makes of strips, in their order.
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

TEST(Fans, HaveEachTetrahedronOnceAndGoFromFaceToFace) {
    const auto mesh = tests::box_mesh({0.06, 0.03, 0.03}, {5, 3, 3});
    const auto fans = interactive::kernels::cut_into_fans(mesh.tetrahedra);
    std::set<int> seen;
    for (const auto &[axis, rim, tetrahedra] : fans) {
        ASSERT_EQ(rim.size(), tetrahedra.size() + 1);
        for (std::size_t k = 0; k < tetrahedra.size(); ++k) {
            EXPECT_TRUE(seen.insert(tetrahedra[k]).second);
            std::set<int> expected{axis[0], axis[1], rim[k], rim[k + 1]};
            const auto &nodes = mesh.tetrahedra[tetrahedra[k]];
            EXPECT_EQ(std::set<int>(nodes.begin(), nodes.end()), expected);
        }
    }
    EXPECT_EQ(seen.size(), mesh.tetrahedra.size());
    EXPECT_LT(fans.size(), mesh.tetrahedra.size() / 3); // so that they are worth it
}

} // namespace
} // namespace livermark
