#include <algorithm>
#include <array>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "core/mesh/neighbours.hpp"
#include "core/mesh/overlaps.hpp"
#include "core/mesh/parts_by_faces.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using Tetrahedra = std::vector<std::array<int, 4>>;

std::array<int, 3> face_of(const std::array<int, 4> &nodes, int face) {
    const auto &[a, b, c] = core::tetrahedron_faces[face];
    return {nodes[a], nodes[b], nodes[c]};
}

template <class Nodes> Nodes ascending(Nodes nodes) {
    std::ranges::sort(nodes);
    return nodes;
}

/// A box with some of its tetrahedra taken out, so that there are holes and parts, in no order.
Tetrahedra box_with_holes(unsigned int seed) {
    auto tetrahedra = tests::box_mesh({0.3, 0.2, 0.1}, {4, 3, 2}).tetrahedra;
    std::mt19937 random(seed);
    std::ranges::shuffle(tetrahedra, random);
    tetrahedra.resize(tetrahedra.size() / 3);
    return tetrahedra;
}

TEST(Faces, AreOuterWhereOneTetrahedronHasThem) {
    for (const unsigned int seed : {1U, 2U, 3U}) {
        const auto tetrahedra = box_with_holes(seed);
        std::map<std::array<int, 3>, int> num_owners;
        for (const auto &nodes : tetrahedra)
            for (int face = 0; face < 4; ++face)
                ++num_owners[ascending(face_of(nodes, face))];
        std::vector<std::array<int, 3>> expected;
        for (const auto &nodes : tetrahedra)
            for (int face = 0; face < 4; ++face)
                if (num_owners[ascending(face_of(nodes, face))] == 1)
                    expected.push_back(face_of(nodes, face));
        EXPECT_LT(expected.size(), 4 * tetrahedra.size());
        EXPECT_EQ(core::outer_faces(tetrahedra), expected);
    }
}

/// Each tetrahedron takes the lowest number in its part, again and again; numbers of parts are then as they come.
std::vector<int> slow_parts(const Tetrahedra &tetrahedra, const std::function<bool(int, int)> &are_joined) {
    const auto num = static_cast<int>(tetrahedra.size());
    const auto share_a_face = [&](int s, int t) {
        return std::ranges::count_if(tetrahedra[s],
                                     [&](int node) { return std::ranges::count(tetrahedra[t], node) > 0; }) == 3;
    };
    std::vector<int> lowest(tetrahedra.size());
    for (int t = 0; t < num; ++t)
        lowest[t] = t;
    for (bool changed = true; changed;) {
        changed = false;
        for (int s = 0; s < num; ++s)
            for (int t = 0; t < num; ++t)
                if (lowest[s] < lowest[t] && share_a_face(s, t) && are_joined(s, t)) {
                    lowest[t] = lowest[s];
                    changed = true;
                }
    }
    std::map<int, int> number;
    std::vector<int> part;
    for (const int of_part : lowest)
        part.push_back(number.try_emplace(of_part, static_cast<int>(number.size())).first->second);
    return part;
}

TEST(Faces, JoinTetrahedraToParts) {
    for (const unsigned int seed : {1U, 2U, 3U}) {
        const auto tetrahedra = box_with_holes(seed);
        const auto always = [](int, int) { return true; };
        const auto alike = [](int s, int t) { return s % 2 == t % 2; };
        const auto parts = core::parts_by_faces(tetrahedra);
        EXPECT_GT(std::ranges::max(parts), 0);
        EXPECT_EQ(parts, slow_parts(tetrahedra, always));
        EXPECT_EQ(core::parts_by_faces(tetrahedra, alike), slow_parts(tetrahedra, alike));
    }
}

TEST(Faces, OfTetrahedraThatRepeatTellTheFirstThatDoes) {
    auto tetrahedra = box_with_holes(1);
    const auto num = static_cast<int>(tetrahedra.size());
    EXPECT_FALSE(core::tetrahedra_of_same_nodes(tetrahedra));
    tetrahedra.push_back(tetrahedra[20]);
    tetrahedra.push_back(tetrahedra[5]);
    tetrahedra.push_back(tetrahedra[20]);
    std::ranges::reverse(tetrahedra.back());
    EXPECT_EQ(core::tetrahedra_of_same_nodes(tetrahedra), (std::pair{20, num}));
}

} // namespace
} // namespace livermark
