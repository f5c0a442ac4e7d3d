#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "msm/dynamics/step_parts.hpp"

namespace livermark::msm {

/// A node at the other end of springs from a lane, and these springs by the node of the lane where they begin: none
/// where there is none.
struct LaneNeighbour {
    int node = -1;
    std::array<int, 2> spring{-1, -1};
    bool is_shared() const { return spring[0] >= 0 && spring[1] >= 0; }
};

/// Two nodes that are moved in one lane, and all that is around them. The ends of an edge inside a mesh of tetrahedra
/// share five or six of their dozen neighbours, which are then fetched once for both.
struct SpringLane {
    std::array<int, 2> node{-1, -1}; ///< -1 where there is no second
    int between = -1;                ///< the spring from one to the other, -1 if there is none
    std::vector<LaneNeighbour> shared;
    std::array<std::vector<LaneNeighbour>, 2> alone; ///< of one of the two; the first has as many or more
    std::size_t num_neighbours() const { return shared.size() + alone[0].size() + alone[1].size(); }
};

/// A spring from a node to another one.
struct SpringEnd {
    int neighbour, spring;
};

/// Two nodes in one lane, in this order whichever has more neighbours.
/// @param nodes      -1 where there is none
/// @param at_first   springs at the first node, by rising neighbour
SpringLane lane_around(const std::array<int, 2> &nodes, const std::vector<SpringEnd> &at_first,
                       const std::vector<SpringEnd> &at_second);

/// Pairs all nodes, those first that share most neighbours, and the rest as they come. The lanes are in reverse
/// Cuthill-McKee order, and sorted by falling number of neighbours within windows of 128.
/// @param parts  with springs, between node numbers below num_nodes
std::vector<SpringLane> spring_lanes(const StepParts &parts, int num_nodes);

/// How many lines of neighbours some lanes side by side need: of shared ones, and of each node alone.
struct LineCounts {
    int shared = 0;
    std::array<int, 2> alone{};
    int total() const { return shared + alone[0] + alone[1]; }
    /// Lines of springs: one between the nodes of the lane, and two for each line of shared neighbours.
    int num_springs() const { return 1 + 2 * shared + alone[0] + alone[1]; }
};

/// The counts that cost least. Where a lane has less to share than the others, a line for shared neighbours takes one
/// of its nodes alone; where it has more, one shared neighbour takes a line of each.
LineCounts fewest_lines(const std::vector<SpringLane> &lanes, std::size_t first, std::size_t last);

} // namespace livermark::msm
