#include <algorithm>
#include <gtest/gtest.h>
#include <set>

#include "core/mesh/tetra_mesh.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

TEST(EdgeTable, HasEachEdgeOnceInLexicographicOrder) {
    const auto mesh = tests::box_mesh({0.3, 0.2, 0.1}, {3, 2, 1});
    std::set<std::array<int, 2>> expected;
    for (const auto &nodes : mesh.tetrahedra)
        for (const auto &[a, b] : core::tetrahedron_edges)
            expected.insert({std::min(nodes[a], nodes[b]), std::max(nodes[a], nodes[b])});
    EXPECT_TRUE(std::ranges::equal(core::edge_table(mesh.tetrahedra).edges, expected));
}

TEST(EdgeTable, LetsEachTetrahedronFindItsEdges) {
    const auto mesh = tests::box_mesh({0.3, 0.2, 0.1}, {3, 2, 1});
    const auto table = core::edge_table(mesh.tetrahedra);
    ASSERT_EQ(table.tetrahedron_edge.size(), mesh.tetrahedra.size());
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        for (std::size_t e = 0; e < 6; ++e) {
            const auto &nodes = mesh.tetrahedra[t];
            const auto [a, b] = core::tetrahedron_edges[e];
            EXPECT_EQ(table.edges[table.tetrahedron_edge[t][e]],
                      (std::array{std::min(nodes[a], nodes[b]), std::max(nodes[a], nodes[b])}));
        }
}

TEST(EdgeTable, OfNoTetrahedraIsEmpty) {
    EXPECT_TRUE(core::edge_table({}).edges.empty());
}

} // namespace
} // namespace livermark
