#pragma once

#include <array>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "msm/cutting/cut_changes.hpp"

namespace livermark::msm {

/// What a cut along facets does to a body whose nodes and tetrahedra keep their numbers.
struct FacetCut {
    std::vector<int> removed; ///< tetrahedra, ascending
    Parting parting;          ///< of those that are left; nothing if no node is parted
};

/// The numbers that CutParts and FastSteps keep, from those of the bodies that meshes::cut() makes one after the other.
class KeptNumbers {
  public:
    /// @param mesh  before any cut
    explicit KeptNumbers(const core::TetraMesh &mesh);

    /// Goes on to what a cut has left of the body. Of the nodes in the place of a node, the first keeps its number.
    /// @param after              after the cut
    /// @param parent_tetrahedron shape (M') that each tetrahedron was in the body before the cut, ascending; corners
    ///                           keep their order
    FacetCut follow(const core::TetraMesh &after, const std::vector<int> &parent_tetrahedron);

    const std::vector<int> &nodes() const { return node_; } ///< (N') number of each node of the body now
    int num_nodes() const { return num_nodes_; }            ///< of all, gone ones included

  private:
    std::vector<std::array<int, 4>> tetrahedra_; // (M) by their nodes' numbers
    std::vector<int> node_, tetrahedron_;        // (N'), (M') of the body now: numbers
    int num_nodes_;
};

} // namespace livermark::msm
