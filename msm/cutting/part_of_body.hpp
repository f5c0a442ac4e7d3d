#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"
#include "msm/cutting/cut_parts.hpp"
#include "msm/elastic_body.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::msm {

/// Some tetrahedra of a body as a body of their own. It has no boundary triangles.
struct PartOfBody {
    core::Body body;
    std::vector<int> node;      ///< of each node of the part: its number in the whole body, ascending
    NodalConditions conditions; ///< of these; no loads
};

/// @param is_in       shape (M) which tetrahedra
/// @param conditions  of the whole body
PartOfBody part_of_body(const core::Body &body, const std::vector<char> &is_in, const NodalConditions &conditions);

/// The highest frequency of what is around a wound, with all else constrained: of the tetrahedra that are left within
/// some rings of tetrahedra around its nodes, set up as a small body of their own. What is constrained more has no
/// higher frequency (Cauchy's interlacing), so that of the whole body is no lower. A mode at the wound does not reach
/// far, and elsewhere nothing has changed: the larger of this and of the frequency before the cut is that of the whole
/// cut body, where the mode before is not at the wound itself.
/// @param body        before the cut, at rest
/// @param is_removed  shape (M) what is gone
/// @param nodes       that have lost tetrahedra
/// @param make        the springs of a body
/// @param conditions  of the nodes of the body
/// @param tolerance   of Lanczos's method, relative
/// @return [rad/s]; zero if nothing there can move
double frequency_around(const core::Body &body, const std::vector<char> &is_removed, std::span<const int> nodes,
                        const std::function<ElasticBody(const core::Body &)> &make, const NodalConditions &conditions,
                        double tolerance);

/// Numbers after a cut along facets, in a body whose nodes and tetrahedra keep their numbers.
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
