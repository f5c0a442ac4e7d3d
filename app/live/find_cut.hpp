#pragma once

#include <optional>
#include <vector>

#include "app/live/part_body.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"
#include "meshes/cutting/cut.hpp"

namespace livermark::live {

/// Remains of a mesh from which tetrahedra are taken away, and which may be parted. Nodes keep their numbers; those
/// that are gone are corners of no tetrahedron.
struct Remains {
    core::TetraMesh mesh;         ///< all nodes; the tetrahedra that are left, in their order, and their boundary
    std::vector<int> tetrahedron; ///< (M) which of the whole mesh these are, ascending
    /// (T) which boundary triangles of the whole mesh these are, ascending; behind them -1 of those in the wound: those
    /// that are parted, as they are in the whole mesh, and those of what was taken, in the order of their tetrahedra.
    std::vector<int> facet;
};

/// @param is_gone     shape (M) of the whole mesh, whose boundary triangles are those of its tetrahedra
/// @param num_facets  boundary triangles of the whole mesh that are not parted; parted ones are behind them
Remains remains_of(const core::TetraMesh &whole, const std::vector<char> &is_gone, std::size_t num_facets);

/// Constraints of what is left: whether each boundary triangle is constrained. The wound is free.
/// @param is_constrained  shape (T) of the whole mesh
std::vector<bool> constrained_remains(const Remains &remains, const std::vector<bool> &is_constrained);

/// Map of stiffness of what is left, see core::Body::modulus_factor.
/// @param whole  before all cuts
std::vector<double> remaining_factors(const Remains &remains, const core::Body &whole);

/// Area of the wound [m^2].
double wound_area(const Remains &remains);

/// A cut that somebody asks for. A region is taken with its margin as at rest, because so it was planned; a plane and a
/// blade meet the body where it is. A blade without thickness parts the body.
struct CutRequest {
    meshes::CutTool tool;
    /// Margin of a region that is kept everywhere: what is nearer than the margin with any point goes as well. By
    /// centroids alone, as in load cases, a large tetrahedron that touches the region at a node may stay.
    bool keeps_margin = false;
    bool takes_loose = false; ///< pieces that nothing holds go as well; otherwise a cut that leaves one is refused
    /// A region whose wound would be a closed cavity comes out by a channel to the surface, which goes as well: see
    /// way_out().
    bool opens = false;
};

struct FoundCut {
    std::vector<int> tetrahedra; ///< that go, in numbers of the whole mesh, ascending
    double volume = 0.0;         ///< of these at rest [m^3]
    double way_volume = 0.0;     ///< of the channel among these [m^3]
    int num_loose = 0;           ///< pieces of more than a hundredth of the body that go because nothing holds them
    int num_pieces = 0;          ///< that are left, each of which is held
    /// Smallest distance at rest between the wound and the lesions that the cut has taken tetrahedra of [m]: the margin
    /// around them. 0 where a part of one is left; no number if there are none.
    double margin = 0.0;
    std::optional<PartedBody> parted; ///< by a blade without thickness, before loose pieces go
};

/// Finds whole tetrahedra that go, by their centroids or by a blade that touches them, or along which faces a blade
/// parts the body, and what does not hold together then: see meshes::cut(), CutWay::facets. Nothing is changed.
/// @param original        before all cuts, at rest
/// @param whole           the same as blades have parted it so far
/// @param before          what earlier cuts have left of it
/// @param is_constrained  shape (T), boundary triangles of the whole mesh that never move
/// @param stands          shape (T), those on springs that resist all directions, which hold a piece as well and may go
/// @param displacement    shape (N), where the body is [m]
/// @throws support::InputError if the tool is none, the cut touches nothing or takes all, takes something of what is
///   constrained, or leaves a piece that nothing holds
FoundCut find_cut(const core::TetraMesh &original, const core::TetraMesh &whole, const Remains &before,
                  const std::vector<bool> &is_constrained, const std::vector<bool> &stands,
                  const std::vector<core::Vector3> &displacement, const CutRequest &request);

} // namespace livermark::live
