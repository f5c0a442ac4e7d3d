#include <algorithm>
#include <gtest/gtest.h>
#include <map>
#include <random>

#include "core/mesh/tetra_mesh.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using msm::LaneNeighbour;
using msm::SpringLane;

/// Springs along the edges of a mesh.
msm::StepParts parts_of(std::vector<std::array<int, 2>> edges) {
    msm::StepParts parts;
    parts.edges = std::move(edges);
    return parts;
}

std::vector<std::array<int, 2>> box_edges() {
    return core::edge_table(tests::box_mesh({0.1, 0.1, 0.1}, {5, 4, 3}).tetrahedra).edges;
}

/// How often each spring is found at each of its ends.
std::map<std::pair<int, int>, int> ends_found(const std::vector<SpringLane> &lanes) {
    std::map<std::pair<int, int>, int> found; // (spring, node at which it is)
    for (const auto &lane : lanes) {
        if (lane.between >= 0)
            for (const int node : lane.node)
                ++found[{lane.between, node}];
        for (const auto *list : {&lane.shared, &lane.alone[0], &lane.alone[1]})
            for (const auto &neighbour : *list)
                for (const int side : {0, 1})
                    if (neighbour.spring[side] >= 0)
                        ++found[{neighbour.spring[side], lane.node[side]}];
    }
    return found;
}

void expect_every_spring_once_at_each_end(const std::vector<std::array<int, 2>> &edges, int num_nodes) {
    const auto lanes = msm::spring_lanes(parts_of(edges), num_nodes);
    std::map<std::pair<int, int>, int> expected;
    for (std::size_t s = 0; s < edges.size(); ++s)
        for (const int node : edges[s])
            ++expected[{static_cast<int>(s), node}];
    EXPECT_EQ(ends_found(lanes), expected);
    std::vector<int> seen(num_nodes, 0);
    for (const auto &lane : lanes)
        for (const int node : lane.node)
            if (node >= 0)
                ++seen[node];
    EXPECT_EQ(seen, std::vector<int>(num_nodes, 1));
}

TEST(SpringLanes, HaveEveryNodeOnceAndEverySpringAtBothEnds) {
    const auto edges = box_edges();
    expect_every_spring_once_at_each_end(edges, 6 * 5 * 4);
    expect_every_spring_once_at_each_end(edges, 6 * 5 * 4 + 3);                // nodes without springs
    expect_every_spring_once_at_each_end({{0, 1}, {1, 0}, {0, 1}, {1, 2}}, 3); // springs side by side
    expect_every_spring_once_at_each_end({}, 5);
    expect_every_spring_once_at_each_end({}, 0);
}

/// A neighbour is shared if, and only if, both nodes of the lane have a spring to it, and the nodes of a lane have one
/// between them wherever there was a choice.
TEST(SpringLanes, FetchOnceWhatBothNodesOfALaneNeed) {
    std::size_t num_between = 0, num_shared = 0, num_alone = 0;
    const auto lanes = msm::spring_lanes(parts_of(box_edges()), 6 * 5 * 4);
    for (const auto &lane : lanes) {
        num_between += lane.between >= 0;
        num_shared += lane.shared.size();
        num_alone += lane.alone[0].size() + lane.alone[1].size();
        EXPECT_GE(lane.alone[0].size(), lane.alone[1].size());
        for (const auto &neighbour : lane.shared)
            EXPECT_TRUE(neighbour.spring[0] >= 0 && neighbour.spring[1] >= 0);
        for (const auto &neighbour : lane.alone[0])
            EXPECT_TRUE(std::ranges::none_of(lane.alone[1], [&](const auto &n) { return n.node == neighbour.node; }));
    }
    EXPECT_GT(num_between, lanes.size() * 8 / 10);
    EXPECT_GT(2 * num_shared, num_alone); // most of the ends outside lanes
}

SpringLane lane(int num_shared, int num_first, int num_second) {
    SpringLane lane;
    lane.shared.resize(num_shared);
    lane.alone[0].resize(num_first);
    lane.alone[1].resize(num_second);
    return lane;
}

/// Whether neighbours find a line each, by the rule that fewest_lines() has.
bool fits(const SpringLane &lane, const msm::LineCounts &count) {
    const int split = std::max(0, static_cast<int>(lane.shared.size()) - count.shared);
    const int room = count.shared - static_cast<int>(lane.shared.size()) + split;
    int missing = 0;
    for (const int side : {0, 1})
        missing += std::max(0, static_cast<int>(lane.alone[side].size()) + split - count.alone[side]);
    return missing <= room;
}

TEST(SpringLanes, TakeAsManyLinesAsTheyNeed) {
    const auto counts = msm::fewest_lines({lane(5, 7, 4)}, 0, 1);
    EXPECT_EQ(counts.shared, 5);
    EXPECT_EQ(counts.alone, (std::array{7, 4}));
    EXPECT_EQ(counts.total(), 16);
    EXPECT_EQ(counts.num_springs(), 22);
    EXPECT_EQ(msm::fewest_lines({lane(0, 0, 0)}, 0, 1).total(), 0);
}

/// No other counts that are enough cost less: to fetch a line as much as the forces of one.
TEST(SpringLanes, FindTheFewestLinesForLanesThatDiffer) {
    std::mt19937 random(3);
    const auto cost = [](const msm::LineCounts &c) { return c.total() + c.num_springs(); };
    for (int sample = 0; sample < 20; ++sample) {
        std::vector<SpringLane> lanes;
        for (int l = 0; l < 5; ++l) {
            const int first = static_cast<int>(random() % 6), second = static_cast<int>(random() % 6);
            lanes.push_back(lane(static_cast<int>(random() % 6), std::max(first, second), std::min(first, second)));
        }
        const auto found = msm::fewest_lines(lanes, 0, lanes.size());
        EXPECT_TRUE(std::ranges::all_of(lanes, [&](const auto &l) { return fits(l, found); }));
        for (int shared = 0; shared < 16; ++shared)
            for (int first = 0; first < 16; ++first)
                for (int second = 0; second < 16; ++second) {
                    const msm::LineCounts other{shared, {first, second}};
                    if (cost(other) < cost(found)) {
                        EXPECT_FALSE(std::ranges::all_of(lanes, [&](const auto &l) { return fits(l, other); }));
                    }
                }
    }
}

} // namespace
} // namespace livermark
