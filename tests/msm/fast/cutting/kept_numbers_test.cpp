#include "msm/cutting/cut_parts.hpp"

#include <gtest/gtest.h>

#include "tests/samples/cut_bodies.hpp"

namespace livermark {
namespace {

using core::Vector3;

/// A box of which tetrahedra go and are parted at once, and its own numbers of what is left.
struct CutBox {
    core::Body kept = tests::crooked_box({0.07, 0.06, 0.05}, {6, 5, 4}); ///< by the numbers that are kept
    std::set<int> removed;
    tests::Rest rest = tests::without(kept, removed);
    std::vector<int> left = numbers_of_left(); ///< the number of each tetrahedron of the rest

    std::vector<int> numbers_of_left() const {
        std::vector<int> numbers;
        for (int t = 0; t < kept.mesh.num_tetrahedra(); ++t)
            if (!removed.contains(t))
                numbers.push_back(t);
        return numbers;
    }
    /// @return parents of tetrahedra in the rest before
    std::vector<int> cut(double x, double distance, msm::Parting &parting) {
        for (const int t : tests::tetrahedra_near(kept, {x, 0.03, 0.05}, distance))
            removed.insert(t);
        parting = tests::part_by_blade(kept, removed, {x, 0.0, 0.0}, Vector3(1.0, 0.2, 0.0), 0.01);
        std::vector<int> parents;
        for (std::size_t t = 0; t < left.size(); ++t)
            if (!removed.contains(left[t]))
                parents.push_back(static_cast<int>(t));
        rest = tests::without(kept, removed);
        left = numbers_of_left();
        return parents;
    }
};

TEST(KeptNumbers, AreThoseOfTheBodyBeforeAllCuts) {
    CutBox box;
    msm::KeptNumbers numbers(box.kept.mesh);
    std::set<int> gone;
    for (const double x : {0.03, 0.045}) {
        msm::Parting expected;
        const auto parents = box.cut(x, 0.014, expected);
        const auto cut = numbers.follow(box.rest.body.mesh, parents);
        gone.insert(cut.removed.begin(), cut.removed.end());
        EXPECT_EQ(gone, box.removed);
        ASSERT_GT(expected.parent_node.size(), 3U);
        EXPECT_EQ(cut.parting.parent_node, expected.parent_node);
        EXPECT_EQ(cut.parting.tetrahedra, expected.tetrahedra);
        EXPECT_EQ(cut.parting.nodes, expected.nodes);
        EXPECT_EQ(numbers.num_nodes(), box.kept.mesh.num_nodes());
        for (int i = 0; i < box.kept.mesh.num_nodes(); ++i)
            if (const int now = box.rest.number[i]; now >= 0) {
                EXPECT_EQ(numbers.nodes()[now], i);
            }
    }
}

TEST(KeptNumbers, PartNothingWhereNothingIsParted) {
    CutBox box;
    msm::KeptNumbers numbers(box.kept.mesh);
    box.removed = {0, 7, 100};
    std::vector<int> parents;
    for (const int t : box.numbers_of_left())
        parents.push_back(t);
    const auto cut = numbers.follow(tests::without(box.kept, box.removed).body.mesh, parents);
    EXPECT_EQ(cut.removed, (std::vector<int>{0, 7, 100}));
    EXPECT_TRUE(cut.parting.tetrahedra.empty());
    EXPECT_TRUE(cut.parting.parent_node.empty());
}

} // namespace
} // namespace livermark
