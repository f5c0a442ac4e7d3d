#include "core/mesh/overlaps.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <vector>

#include "core/mesh/neighbours.hpp"

namespace livermark::core {
namespace {

TEST(Overlaps, OfNodesAreFoundWithinABillionthOfTheExtent) {
    std::vector<Vector3> points{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    EXPECT_FALSE(nodes_in_one_place(points));
    points.emplace_back(0.0, 1.0 + 1e-8, 0.0);
    EXPECT_FALSE(nodes_in_one_place(points));
    points.emplace_back(1e-10, 1.0, 0.0);
    EXPECT_EQ(nodes_in_one_place(points), (std::pair{2, 5}));
    EXPECT_FALSE(nodes_in_one_place(points, [](int a, int b) { return a + b == 7; }));
    EXPECT_FALSE(nodes_in_one_place({}));
}

TEST(Overlaps, OfTetrahedraAreFoundInAnyOrderOfTheirNodes) {
    std::vector<std::array<int, 4>> tetrahedra{{0, 1, 2, 3}, {1, 2, 3, 4}};
    EXPECT_FALSE(tetrahedra_of_same_nodes(tetrahedra));
    EXPECT_FALSE(face_of_too_many(sorted_faces(tetrahedra)));
    tetrahedra.push_back({3, 1, 5, 2});
    EXPECT_FALSE(tetrahedra_of_same_nodes(tetrahedra));
    EXPECT_EQ(face_of_too_many(sorted_faces(tetrahedra)), (std::array{1, 2, 3}));
    tetrahedra.push_back({4, 3, 2, 1});
    EXPECT_EQ(tetrahedra_of_same_nodes(tetrahedra), (std::pair{1, 3}));
}

TEST(Overlaps, KnowEachFaceAsOftenAsThereAreTetrahedra) {
    const std::vector<std::array<int, 4>> tetrahedra{{0, 1, 2, 3}, {4, 3, 2, 1}};
    const auto faces = sorted_faces(tetrahedra);
    EXPECT_EQ(faces.size(), 8U);
    EXPECT_EQ(std::ranges::count(faces, std::array{1, 2, 3}, &TetrahedronFace::nodes), 2);
}

} // namespace
} // namespace livermark::core
