#pragma once

#include <array>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/problem.hpp"
#include "core/support/input_error.hpp"

namespace livermark::meshes {

/// Takes away a region with all that is nearer to it than a margin.
struct RegionCut {
    std::string region;
    double margin = 0.0; ///< [m], >= 0
    bool operator==(const RegionCut &) const = default;
};

/// Takes away all on the side of a plane to which its normal points.
struct HalfSpaceCut {
    core::Vector3 point;  ///< [m], on the plane
    core::Vector3 normal; ///< of any length above 0
    bool operator==(const HalfSpaceCut &) const = default;
};

/// Surface that a straight blade sweeps: the quadrilateral of two triangles with corners 0 1 2 and 0 2 3. Takes away
/// all that is nearer to it than half the thickness; a blade without thickness parts the body and takes nothing away.
struct BladeCut {
    std::array<core::Vector3, 4> corners; ///< [m], in turn; the blade's edge goes from 0-1 to 3-2
    double thickness = 0.0;               ///< [m], >= 0
    bool operator==(const BladeCut &) const = default;
};

using CutTool = std::variant<RegionCut, HalfSpaceCut, BladeCut>;

/// Place of the new surface.
enum class CutWay {
    /// Along faces of tetrahedra. Those whose centroid is in what is taken away go as a whole, and of a blade all that
    /// it
    /// touches. A blade without thickness parts the faces between centroids on either side of it.
    facets,
    /// Along the surface of what is taken away, at which tetrahedra are split. A blade that ends inside ends at a face.
    exact
};

/// Fate of all pieces but the largest. Crumbs, of less than a hundredth of the body, are always taken away.
enum class SmallPieces {
    refuse, ///< a piece that floats is a mistake
    remove, ///< they are taken away
    keep    ///< they are bodies of their own
};

struct Cut {
    CutTool tool;
    CutWay way = CutWay::facets;
    SmallPieces small_pieces = SmallPieces::refuse;
    std::string place = "cut"; ///< where it was read, for messages
};

/// A cut that does not fit this body: it misses it, takes all of it away, or leaves what floats. It may fit another
/// one.
class CutNotOnBody : public support::InputError {
  public:
    CutNotOnBody(const std::string &place, std::string reason, std::string remedy);

    const std::string &place() const { return place_; }
    const std::string &reason() const { return reason_; } ///< a clause
    const std::string &remedy() const { return remedy_; }

  private:
    std::string place_, reason_, remedy_;
};

/// A cut that touches nothing of the body.
class CutMissesBody : public CutNotOnBody {
  public:
    using CutNotOnBody::CutNotOnBody;
};

/// Remains of a cut.
struct CutBody {
    core::Body body;                       ///< the largest piece
    std::vector<core::Body> small_pieces;  ///< with SmallPieces::keep, the largest first, named <body>_piece_2 ...
    std::vector<std::vector<int>> parents; ///< of each tetrahedron of the body and of each piece: number of the
                                           ///< tetrahedron before that it is, or is a part of; ascending
    double volume_before = 0.0;            ///< [m^3]
    double removed_volume = 0.0;           ///< [m^3], summed over what was taken away
    double removed_mass = 0.0;             ///< [kg]
    double wound_area = 0.0;               ///< [m^2] of the body
    double least_margin = 0.0;             ///< from the region of a RegionCut to the wound [m]; NaN without a margin
    int num_crumbs = 0;                    ///< pieces that were too small to stay
    int num_spikes = 0;                    ///< tetrahedra that hung on one face, with two or three in the wound
    int num_bridges = 0;                   ///< tetrahedra that alone joined two parts
    int num_hinges = 0;                    ///< edges and nodes at which parts of the wound touched
    std::vector<std::string> notes;        ///< a sentence each
};

/// Cuts a body. It keeps its regions, materials and patches; those of which nothing is left lose their names. The new
/// surface is the patch "wound". Volume is conserved: what is removed and what is left have that of the body before, to
/// rounding.
///
/// The surface that is left is closed, and at the wound it is a manifold: crumbs, spikes (tetrahedra on one face),
/// bridges (one tetrahedron that joins two parts) and hinges (edges and nodes where the wound touches itself) are taken
/// away. A parted surface has its nodes twice, in one place.
///
/// Along the exact surface nodes inside the body move onto it where they are nearer than 0.3 of an edge, and those on
/// its boundary or between regions stay and count as on it within 0.2 of an edge: so far the rim of the wound may be
/// off. Features smaller than an edge are lost. The facets of the wound are chords: around a region that bulges they
/// are nearer to it than the margin (CutBody::least_margin).
/// @throws support::InputError   for a tool that is none: a negative margin or thickness, a normal of length 0, a blade
///                               without an area
/// @throws CutMissesBody         if the cut touches nothing
/// @throws CutNotOnBody          if there is no such region, if the cut leaves nothing, if it leaves several pieces and
///                               none may float
CutBody cut(const core::Body &body, const Cut &cut);

/// One cut after the other; small pieces are not kept. The notes are added to the assumptions of the body.
/// @throws support::InputError  as above, if the same cut is there twice, and for SmallPieces::keep
core::Body cut(core::Body body, std::span<const Cut> cuts);

/// The tool in a few words.
std::string to_text(const CutTool &tool);

} // namespace livermark::meshes
