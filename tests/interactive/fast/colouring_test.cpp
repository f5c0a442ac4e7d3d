#include <algorithm>
#include <gtest/gtest.h>
#include <set>
#include <stdexcept>

#include "interactive/colouring.hpp"
#include "interactive/method.hpp"
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

TEST(Scene, WithoutAMassForEachNodeIsRefused) {
    auto scene = tests::bar_scene(true);
    scene.node_mass.pop_back();
    EXPECT_THROW(interactive::find_method("corotational_implicit").prepare(scene), std::invalid_argument);
}

TEST(Scene, WithANodeConstrainedTwiceIsRefused) {
    auto scene = tests::bar_scene(true);
    scene.constrained_nodes.push_back(scene.constrained_nodes.front());
    EXPECT_THROW(interactive::find_method("corotational_implicit").prepare(scene), std::invalid_argument);
}

TEST(Method, IsNotFoundUnderAnotherName) {
    EXPECT_THROW(interactive::find_method("nothing"), std::invalid_argument);
}

} // namespace
} // namespace livermark
