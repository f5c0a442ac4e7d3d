#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/segmentation/images/segmentation.hpp"

namespace livermark::segmentation {

/// The regions of a body as smooth fields on a grid of cubes: what the mesher sees of it, whether it was an image or
/// surfaces before.
struct LabelFields {
    std::array<int, 3> size = {0, 0, 0};    ///< samples along each axis
    double spacing = 0.0;                   ///< [m]
    core::Vector3 low = {0.0, 0.0, 0.0};    ///< place of the first sample, in the axes of the image [m]
    std::vector<std::vector<float>> inside; ///< (R) of (samples), the first axis runs fastest: about 1 well inside the
                                            ///< region, 0 well outside it, about 1/2 on its border; 0 on the
                                            ///< border of the grid
    std::vector<double> volume;             ///< (R) that the region has to have in the end [m^3]
};

/// The share of each region in the surroundings of a sample (a Gaussian whose width goes with the voxels), so that the
/// borders are free of the stairs that voxels make.
/// @param spacing  of the samples [m]; no finer than pays for the tetrahedra that are wanted
LabelFields label_fields(const Segmentation &segmentation, double spacing);

inline constexpr int outside = -1; ///< label of all that is not the body

/// Fields with what makes labels of them: a place is inside the body where the sum of the fields is above a threshold,
/// and there it belongs to the region whose weighted field is largest.
struct LabelDomain {
    LabelFields fields;
    std::vector<float> body;         ///< (samples) sum of the fields
    double threshold = 0.5;          ///< of the sum
    std::vector<double> weight;      ///< (R) of the fields
    std::vector<std::int16_t> label; ///< (samples) region or `outside`
};

/// Threshold and weights with which body and regions have the volumes wanted, as far as counted samples tell.
LabelDomain match_volumes(LabelFields fields);

/// Region at a place of the image's axes [m], between the samples by trilinear interpolation; or `outside`.
int label_at(const LabelDomain &domain, const core::Vector3 &place);

/// Number of labels that may meet at a point for the functions below: two surfaces cross in a curve, three in a point.
inline constexpr int max_labels = 4;
using Levels = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_labels - 1, 1>;
using LevelGradients = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, max_labels - 1, 3>;

/// Functions that vanish where several labels meet: for each label but the last, how far it is ahead of the next.
/// @param labels  two to max_labels distinct ones, `outside` first if it is there
/// @return (labels - 1) without unit
Levels level_differences(const LabelDomain &domain, const core::Vector3 &place, const std::vector<int> &labels);

/// @return (labels - 1) x 3, gradient of level_differences [1/m], by central differences
LevelGradients level_gradients(const LabelDomain &domain, const core::Vector3 &place, const std::vector<int> &labels);

/// The part of each gradient that is at right angles to those before it, so that a step along one does not disturb
/// them. Zero where surfaces graze each other, because the curve that they meet in is then anywhere; the surface that
/// comes first, the capsule if it is there, has precedence.
LevelGradients independent_normals(LevelGradients gradients);

/// The nearest place, as far as Newton's steps tell, where level_differences has the given values.
core::Vector3 project_to_levels(const LabelDomain &domain, core::Vector3 place, const std::vector<int> &labels,
                                const Levels &values);

/// Neighbours in a mesh of several regions.
struct MeshLinks {
    std::vector<std::vector<int>> tetrahedra_of; ///< (N) numbers of the tetrahedra at a node, ascending
    std::vector<std::array<int, 4>> neighbour;   ///< (M) tetrahedron across the face opposite each corner, -1: none
    std::vector<std::vector<int>> labels_of;     ///< (N) regions that meet at a node, `outside` first if it is there
};

MeshLinks mesh_links(const core::TetraMesh &mesh);

/// The region on the other side of the face opposite a corner, or `outside`.
int region_across(const core::TetraMesh &mesh, const MeshLinks &links, int tetrahedron, int corner);

/// 0 to 3, where a node is among the corners of a tetrahedron, or -1.
int corner_of(const std::array<int, 4> &nodes, int node);

/// Quality 6 sqrt(2) V / l_rms^3 of a tetrahedron of these nodes.
double quality_of(const core::TetraMesh &mesh, const std::array<int, 4> &nodes);

double mean_edge_length(const core::TetraMesh &mesh); ///< [m]

/// Takes out the tetrahedra that have no region (`outside`), and the nodes that nothing uses.
void drop_unused(core::TetraMesh &mesh);

/// Changes of who is connected to whom. Each looks at every place once and does not touch one twice; none
/// changes the topology of the body. The returned number says how many changes there were.

/// Collapses short edges where that leaves fair tetrahedra. Borders shrink to fewer nodes of themselves; where two
/// borders inside the body, or one and the boundary, are closer than `tight`, they become one.
/// @param shortest, tight, longest  [m] edges to collapse, edges to collapse across a layer, and edges that must not
///                                  come of it
int collapse_edges(core::TetraMesh &mesh, double shortest, double tight, double longest);

/// Replaces the tetrahedra around an edge inside a region by those of a better triangulation of the ring around it
/// (3-2, 4-4, 5-6, 6-8 swaps; Freitag and Ollivier-Gooch 1997) where the worst of them is below this quality.
int remove_edges(core::TetraMesh &mesh, double quality);

/// 2-3 swaps inside a region where that makes the worse of the two better and it is below this quality.
int swap_faces(core::TetraMesh &mesh, double quality);

/// Gives tetrahedra below this quality that lie flat on the border of their region, two faces on it, to the region on
/// the other side, or takes them away at the boundary.
int peel_flat(core::TetraMesh &mesh, double quality);

/// Moves of nodes that leave the connections as they are.

/// Moves the nodes of all borders onto the level sets of the domain, as far as their tetrahedra stay fair.
void snap_to_levels(core::TetraMesh &mesh, const LabelDomain &domain);

/// Hill climbing: every node at a tetrahedron below this quality goes where the worst of its tetrahedra is better.
/// Nodes of borders slide along the level set that they are on, which need not be that of the border.
void climb(core::TetraMesh &mesh, const LabelDomain &domain, double quality);

/// Moves the nodes of the borders along their normals, evenly, until each region has the volume wanted: Newton's steps,
/// each the smallest change (weighted with the area) that the derivatives of all volumes ask for together. What a step
/// would make worse than fair is left, so that volumes may be missed.
/// @param wanted  (R) [m^3]
void correct_volumes(core::TetraMesh &mesh, const std::vector<double> &wanted);

/// @return (num_regions) [m^3]
std::vector<double> volumes_of_regions(const core::TetraMesh &mesh, std::size_t num_regions);

/// A part of a region that hangs together.
struct LabelPiece {
    int region = 0;
    double volume = 0.0;   ///< [m^3]
    core::Vector3 deepest; ///< a sample that is as far from the border as any [m]
};

/// The pieces of all regions, region by region and the largest first; neighbours are samples side by side.
/// @param smallest  volume below which a piece is noise [m^3]; the largest of each region is there however small
std::vector<LabelPiece> find_pieces(const LabelDomain &domain, double smallest);

/// A place on the border between two labels.
struct BorderPoint {
    core::Vector3 place; ///< [m]
    int from = 0;        ///< labels on its two sides
    int to = 0;
};

/// Points where rays from the deepest place of each piece leave it: with some of these points to start from a mesher
/// cannot overlook the piece. No two are closer than goes with the size of the tetrahedra and the piece.
/// @param edge  of the tetrahedra that are wanted [m]
std::vector<BorderPoint> border_points(const LabelDomain &domain, const std::vector<LabelPiece> &pieces, double edge);

/// Number of pieces that the regions have in the mesh beyond or below those wanted, all in all.
int num_wrong_pieces(const core::TetraMesh &mesh, const std::vector<LabelPiece> &wanted);

/// Places where the boundary is not a manifold: edges that other than two boundary triangles share, and nodes whose
/// triangles do not make one fan.
int num_pinches(const core::TetraMesh &mesh);

/// Separate closed surfaces that bound the mesh: 1 for a body without cavities.
int num_shells(const core::TetraMesh &mesh);

/// Gives islands to the region around them, removes what the body does not hang together with, and takes away the
/// smaller side of every place where the boundary is no manifold, as far as a few rounds go.
void clean(core::TetraMesh &mesh, const std::vector<LabelPiece> &wanted);

} // namespace livermark::segmentation
