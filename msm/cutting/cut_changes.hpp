#pragma once

#include <array>
#include <vector>

namespace livermark::msm {

/// Numbers of what a cut has changed, as in StepParts, each ascending and once.
struct CutChanges {
    std::vector<int> tetrahedra; ///< that are gone
    std::vector<int> nodes;      ///< corners of these: their masses
    std::vector<int> springs;    ///< edges of these: their stiffness
    std::vector<int> volumes;    ///< control volumes that have lost some of their volume
    std::vector<int> edge_parts; ///< means around edges that have lost tetrahedra
};

/// What a blade without thickness does: all tetrahedra stay, and some have other nodes, which are in the places of
/// those before.
struct Parting {
    std::vector<int> tetrahedra;           ///< that have other nodes, ascending
    std::vector<std::array<int, 4>> nodes; ///< all nodes of these from now on; new ones are numbered from N on
    std::vector<int> parent_node;          ///< of each new node, the one before from which it is parted
};

/// Numbers of what a parting has changed, as in StepParts, each ascending and once. What is new is numbered behind what
/// was there.
struct PartingChanges {
    std::vector<int> tetrahedra;   ///< that have other nodes
    std::vector<int> parent_node;  ///< of each new node
    std::vector<int> nodes;        ///< parents, and new nodes: their masses
    std::vector<int> springs;      ///< edges that have lost tetrahedra, and new ones; of laws that look at the whole
                                   ///< body, all
    std::vector<int> gone_springs; ///< of these, those that have lost the last one
    int first_new_spring = 0;
    std::vector<int> volumes;    ///< control volumes around a node of these tetrahedra, before or now
    std::vector<int> edge_parts; ///< means around an edge of these tetrahedra, before or now
    /// Of each new part around an edge, the one before whose tetrahedra it has
    std::vector<int> parent_edge_part;
};

} // namespace livermark::msm
