#pragma once

#include <vector>

#include "live/cutting/remains.hpp"
#include "meshes/cutting/cut.hpp"

/// Which tetrahedra a cut takes away from a body that moves.
namespace livermark::live {

/// What somebody asks to be cut. A region is taken with its margin as at rest, because so it was planned; a plane and a
/// blade meet the body where it is.
struct CutRequest {
    meshes::CutTool tool; ///< that takes something away: a blade has a thickness
    /// Of a region: what is nearer than the margin with any point goes as well, so that it is left everywhere. By
    /// centroids alone, as in load cases, a large tetrahedron that touches the region at a node may stay.
    bool keeps_margin = false;
    bool takes_loose = false; ///< pieces that nothing holds go as well; otherwise a cut that leaves one is refused
};

struct FoundCut {
    std::vector<int> tetrahedra; ///< that go, in numbers of the whole mesh, ascending
    double volume = 0.0;         ///< of these at rest [m^3]
    int num_loose = 0;           ///< pieces of more than a hundredth of the body that go because nothing holds them
    int num_pieces = 0;          ///< that are left, each of which is held
    /// Smallest distance at rest between the wound and the lesions that the cut has taken tetrahedra of [m]: the margin
    /// around them. 0 where a part of one is left; no number if there are none.
    double margin = 0.0;
};

/// Finds whole tetrahedra that go, by their centroids or by a blade that touches them, and what does not hold together
/// without them: see meshes::cut(), CutWay::facets. Nothing is changed.
/// @param whole           before all cuts, at rest
/// @param before          what earlier cuts have left of it
/// @param is_constrained  shape (T), boundary triangles of the whole mesh that never move
/// @param displacement    shape (N), where the body is [m]
/// @throws support::InputError if the tool is none, the cut touches nothing or takes all, takes something of what is
///   constrained, or leaves a piece that nothing holds
FoundCut find_cut(const core::TetraMesh &whole, const Remains &before, const std::vector<bool> &is_constrained,
                  const std::vector<core::Vector3> &displacement, const CutRequest &request);

} // namespace livermark::live
