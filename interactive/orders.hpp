#pragma once

#include <array>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "interactive/kernels/fans.hpp"

namespace livermark::interactive {

/// What of the layout of a body is a choice among many: in which order nodes, tetrahedra and edges stand, and which of
/// them are visited at once. These choices take most of the time of a set-up. They stay good, if not best, when
/// tetrahedra go or are parted, so that a body that is cut keeps them. What a method does not use is empty.
struct Orders {
    std::vector<int> rows;               ///< (N) nodes as rows come
    kernels::FanList fans;               ///< each tetrahedron in one of them, as they stand side by side
    std::vector<int> tetrahedron_colour; ///< (M) no two of a colour share a node; -1 where it has none
    core::EdgeTable edges;               ///< core::edge_table(), where edges have colours
    std::vector<int> edge_colour;        ///< (S) the same of these edges
    std::vector<int> node_colour;        ///< (N) no two of a colour are in a tetrahedron
    /// (N) facets opposite a node as strips, whose triangles are numbers of tetrahedra; none where it is constrained
    std::vector<std::vector<kernels::StripNode>> strips;
    std::vector<int> factor; ///< free nodes in the order in which they are eliminated
};

/// Where the nodes and the tetrahedra of a body come from that was cut along its facets.
struct Parents {
    std::vector<int> tetrahedron; ///< (M') that each was before, no two the same; corners keep their order
    std::vector<int> node;        ///< (N') that each was, or was parted from
};

/// @param tetrahedron  as in Parents
Parents parents_of(const core::TetraMesh &before, const core::TetraMesh &after, std::vector<int> tetrahedron);

/// The edges of what a cut has left, from those before.
struct CutEdges {
    core::EdgeTable table;   ///< that of core::edge_table()
    std::vector<int> parent; ///< (S') the edge before that each is, or was parted from
};

/// Edges that a cut has not parted are taken over, and only copies are put in order.
/// @param edges  of core::edge_table() before
CutEdges edges_as_cut(const core::EdgeTable &edges, const core::TetraMesh &after, const Parents &parents);

/// The orders of what a cut has left, from those before: what is gone is left out; parted nodes stand side by side; a
/// fan that was cut through is two; colours stay, but of edges that were parted and still share a node. Strips are
/// kept where the cut has not changed the tetrahedra of a node nor parted a neighbour, and are empty elsewhere.
Orders as_cut(const Orders &orders, const core::TetraMesh &before, const core::TetraMesh &after,
              const Parents &parents);

} // namespace livermark::interactive
