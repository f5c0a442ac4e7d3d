#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <boost/align/aligned_allocator.hpp>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "msm/cutting/cut_parts.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// Tetrahedra around an edge, each of which shares a face with the next: (axis, rim k, rim k + 1) is tetrahedron k,
/// with the sign of its volume kept. One new node is enough for each but the first.
struct Fan {
    std::array<int, 2> axis;
    std::vector<int> rim;        ///< (m + 1) node numbers; the first and the last are the same where the fan is closed
    std::vector<int> tetrahedra; ///< (m) numbers
};

/// Cuts a mesh into fans, long ones first, each tetrahedron in one of them.
/// @param tetrahedra     shape (M), node numbers
/// @param corner_volume  shape (M) or empty; what these say of a node is the same for all tetrahedra of a fan
std::vector<Fan> cut_into_fans(const std::vector<std::array<int, 4>> &tetrahedra,
                               const std::vector<std::array<int, 4>> &corner_volume);

/// An order of nodes in which neighbours stand close to each other: reverse Cuthill and McKee (Boost.Graph).
/// (Cuthill, McKee 1969, Proc. 24th ACM National Conference; George 1971)
/// @param edges  shape (S), node numbers below num_nodes
/// @return shape (num_nodes), the old number of each new node
std::vector<int> reverse_cuthill_mckee(std::span<const std::array<int, 2>> edges, int num_nodes);

/// Sorts within windows of that many, so that what is alike stands side by side and stays near where it was.
template <class T, class Less> void sort_in_windows(std::vector<T> &items, std::size_t window, const Less &less) {
    for (std::size_t first = 0; first < items.size(); first += window) {
        const auto begin = items.begin() + static_cast<std::ptrdiff_t>(first);
        const auto end = items.begin() + static_cast<std::ptrdiff_t>(std::min(first + window, items.size()));
        std::stable_sort(begin, end, less);
    }
}

/// Reverse Cuthill-McKee order with nodes next to each other that have about as many neighbours: sorted by falling
/// degree within windows of 256. (Kreutzer et al. 2014, SIAM J. Sci. Comput. 36(5))
std::vector<int> order_by_degree(std::span<const std::array<int, 2>> edges, int num_nodes);

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

/// Numbers of lines of neighbours that some lanes side by side need: of shared ones, and of each node alone.
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

/// The tetrahedra that give a quarter of themselves to each control volume, ascending, removed ones included.
inline NumberLists volume_members(const StepParts &parts) {
    return NumberLists(parts.corner_volume, parts.centre.size());
}

/// Volume of each tetrahedron at rest, removed ones included [m^3].
/// @param x  shape (3N) [m], at rest
std::vector<double> rest_volumes(const StepParts &parts, const Eigen::VectorXd &x);

/// V0_c of a control volume around a node: a quarter of each of its tetrahedra that are there [m^3].
/// @param volumes  of tetrahedra, from rest_volumes()
/// @param members  of the control volume
double rest_volume(const StepParts &parts, std::span<const double> volumes, std::span<const int> members);

/// Nodes, or fans of tetrahedra, in a slice: as many as the widest vectors have lanes. Narrower ones take a slice in
/// several goes, so that one layout serves every machine.
inline constexpr int slice_size = 16;

/// Fans whose forces are summed together: few enough that their nodes stay in the fastest cache, enough to find sixteen
/// of the same length.
inline constexpr int chunk_size = 512;

/// Numbers of a row of a tetrahedron or an edge: of means of C six and two that are nought, of F nine and three.
constexpr int long_row(StrainMeasure measure) {
    return measure == StrainMeasure::deformation_gradient ? 12 : 8;
}

/// Row of a lane among those of a slice. Vectors of 16 lanes are transposed in blocks of four: this is the order in
/// which the lanes come out of it.
constexpr int row_of_lane(int lane) {
    return lane / 4 + 4 * (lane % 4);
}

/// Starts at a cache line.
template <class T> using Aligned = std::vector<T, boost::alignment::aligned_allocator<T, 64>>;

/// Slices come in pairs: that of the first nodes of 16 lanes, and that of the second ones.
inline constexpr int pair_size = 2 * slice_size;

/// Springs at the nodes of a pair of slices: where their lines begin, in units of 16, and how many there are. The lines
/// of neighbours are those that both nodes of a lane share, then those of the first nodes alone and of the second ones;
/// the lines of springs are those between the nodes of a lane, then two for each of the shared, and one for each other.
struct SpringLines {
    int first_neighbour = 0, first_spring = 0;
    LineCounts count;
};

/// The parts of a body for vector units: sliced ELLPACK (SELL-C-sigma of Kreutzer et al. 2014, SIAM J. Sci. Comput.
/// 36(5)). A slice is 16 nodes of about the same degree; the d-th neighbours of all of them are next to each other, and
/// slices with fewer are filled up with springs of no stiffness. Every spring is kept at both of its ends, so that each
/// node collects its own force and no two write to one place. To fetch a neighbour takes longer than the force of a
/// spring: so a lane moves two nodes that share as many neighbours as they can, and fetches these once. The spring
/// between the two is kept once.
///
/// Where nodes are is kept in rows of four numbers, x y z and the pressure around the node, which one load brings. A
/// node on a boundary between regions has a control volume in each: the first is in its own row, the others have copies
/// of the row behind those of all nodes.
///
/// Tetrahedra come in fans around edges, so that one node has to be fetched for most of them, and not four. Every chunk
/// of fans adds up forces in places of its own, which the nodes then collect. Springs that are coupled are found in
/// the same fans, and around nodes in the same control volumes.
/// @tparam T  of everything that forces are made from
template <class T> struct SlicedBody {
    int num_slices = 0; ///< of nodes, an even number
    int num_rows = 0;   ///< a multiple of 16, copies included; one more is the far one
    std::vector<int> row_of_node;
    std::vector<int> copy_start; ///< (slices + 1) first of its copies
    std::vector<int> copied_row; ///< what to copy, for each copy
    int first_copy = 0;          ///< the row of the first

    std::vector<SpringLines> spring_lines; ///< (slices / 2); empty if there are no springs
    Aligned<std::int32_t> neighbour;       ///< (lines, 16) index of the other end: four times its row
    Aligned<T> spring;                     ///< (lines, 2, 16) k [N/m] and k l0 / 2 [N]

    /// (fan slices + 1) tetrahedra of 16 fans, one of each on a line, in units of 16; short fans are filled up with
    /// tetrahedra without volume
    std::vector<int> fan_start;
    /// (lines + 3 for each fan slice, 16) indices of the nodes: both ends of the axis, and the rim
    Aligned<std::int32_t> corner;
    Aligned<std::int32_t> force_slot; ///< of the same shape: where the force on each is added
    Aligned<T> rest_volume;           ///< (lines, 16) [m^3]
    Aligned<T> volume_share;          ///< (lines, 16) 1, and 0 where there is no tetrahedron, or one that is removed
    Aligned<T> tetrahedron_stiffness; ///< (lines, 16) [Pa/m^3]; empty if there is none, as are the following
    Aligned<T> least_volume;          ///< (lines, 16) [m^3]
    Aligned<T> guard_stiffness;       ///< (lines, 16) [Pa/m^3]
    Aligned<T> watched_volume;        ///< (lines, 16) [m^3]
    std::vector<int> chunk_fans;      ///< (chunks + 1) first fan slice of each
    std::vector<int> chunk_start;     ///< (chunks + 1) first place of each: one for every node that it touches
    std::vector<int> sum_start;       ///< (slices + 1) places to sum for the nodes of a slice, in units of 16
    Aligned<std::int32_t> sum;        ///< one of these places; one behind the last, where nothing is added, as filling

    StrainMeasure measure = StrainMeasure::elongation; ///< of springs that are coupled
    /// (lines, 9, 16) of each tetrahedron at rest, the gradients of the barycentric coordinates of three corners, which
    /// are the end of the axis and both nodes of the rim [1/m]. Empty if no springs are coupled.
    Aligned<T> rest_gradient;
    /// (lines, 6, 16) lengths of the edges of each tetrahedron: from the start of the axis to these three corners, and
    /// from the first of them to the second and so on around [m]. Empty if no springs are coupled around nodes, as are
    /// the following.
    Aligned<T> rest_length;
    Aligned<T>
        inner_modulus; ///< (lines, 16) of springs inside a tetrahedron [Pa]; with means of C or F times its volume
    Aligned<T> volume_modulus; ///< (lines, 16) of springs inside a tetrahedron [Pa]
    /// (volumes) of springs around a node, 1/16 of the shear modulus by volume [Pa/m^3]; with means of C a quarter
    /// of the shear modulus [Pa], with means of F the shear modulus times the volume [J]
    Aligned<T> coupled_modulus;
    /// (volumes) with means of C or F alone, without rest_length: 1 over four times the volume at rest [1/m^3]
    Aligned<T> inverse_volume;
    /// Springs around nodes with means of F alone have these, see mean_gradients(): where the neighbours in the
    /// control volumes begin, in units of 16 (volumes / 16 + 1), four times the row of each (lines, 16), and what is
    /// asked of their position less that of the node in the middle (lines, 4, 16), b [1/m] and k [N/m]
    std::vector<int> mean_start;
    Aligned<std::int32_t> mean_node;
    Aligned<T> mean_gradient;
    /// The first place where a control volume puts the force on a neighbour, one for each on the lines; behind these is
    /// one for each volume, for the node in the middle. 0 if there are none
    int first_pull = 0;

    /// Springs around edges alone have these. An edge has a lane in each material there: where the tetrahedra around 16
    /// of them begin, in units of 16 (edge slices + 1), the index of the row of each (lines, 16), one behind the last
    /// where there is none, and (edge slices, 16) 1/6 of the shear modulus [Pa] and 1 over the volume at rest of these
    /// tetrahedra [1/m^3]
    std::vector<int> edge_start;
    Aligned<std::int32_t> edge_member;
    Aligned<T> edge_modulus, inverse_edge_volume;
    /// (lines + 1 for each fan slice, 3, 16) indices of the rows of the edges of fans: the axis and the edges from its
    /// ends to the first node of the rim; then, for each tetrahedron, the edge between its nodes of the rim and those
    /// from the ends of the axis to the second one
    Aligned<std::int32_t> fan_edge;

    /// Neighbours where changes of volume are averaged: which control volumes are the neighbours of each, from
    /// mean_start on, and their part in the mean (lines, 16); a quarter is its own
    Aligned<std::int32_t> mean_volume;
    Aligned<T> mean_weight;

    bool is_around_edges() const { return !edge_start.empty(); }
    /// Whether tetrahedra bear volumes alone, as stresses have gone to the nodes before.
    bool has_volumes_in_fans() const { return !mean_gradient.empty(); }

    /// (volumes) the row of each control volume, near each other in order, and of about as many tetrahedra; filled up
    /// with the far row
    std::vector<int> volume_row;
    std::vector<int> volume_start; ///< (volumes / 16 + 1) corners of fans in the volumes, in units of 16
    Aligned<std::int32_t> member;  ///< the corner; one behind the last where there is none. Where springs are coupled,
                                   ///< eight times a tetrahedron around the node; four times a corner with
                                   ///< means of C, the corner with means of F
    /// (volumes) a quarter of the pressure for each m^3 gained [Pa/m^3], beside springs with means of C or F a quarter
    /// of the modulus [Pa]
    Aligned<T> volume_stiffness;
};

/// Place of a spring that is on no lines.
inline constexpr std::size_t no_place = static_cast<std::size_t>(-1);

/// Facts of a sliced body that are needed to change it where tetrahedra are taken away or parted.
struct SlicedPlan {
    Eigen::VectorXd rest;               ///< (3N) [m]
    std::vector<double> rest_volume;    ///< (M) of tetrahedra, from rest [m^3]
    std::vector<int> tetrahedron_place; ///< (M) on the lines
    std::vector<Fan> fans;              ///< side by side as they stand, removed tetrahedra included
    std::vector<int> fan_slice;         ///< (lines) of fans that each line is in
    std::vector<int> node_of_row;       ///< (first_copy) -1 where nobody is
    /// (S) places in SlicedBody::spring, the same twice for one, no_place for a spring that is gone
    std::vector<std::array<std::size_t, 2>> springs;
    NumberLists springs_of_node;       ///< (N) that are not gone
    std::vector<int> number_of_volume; ///< (C) which control volume of the sliced body it is
    NumberLists members;               ///< of the control volumes
    NumberLists edge_members;          ///< (E) tetrahedra around edges, removed ones included
    std::vector<int> edge_lane;        ///< (E)
};

/// @param positions  shape (N) [m], at rest
/// @param plan       told what update_sliced_body() asks for, if anybody wants to know
template <class T>
SlicedBody<T> sliced_body(const StepParts &parts, const std::vector<core::Vector3> &positions,
                          SlicedPlan *plan = nullptr);

/// Changes a sliced body where tetrahedra are removed: to the bit what sliced_body() makes of the parts now. Lines and
/// lanes stay; in place of a tetrahedron that is gone is one without volume.
/// @param changes  what differs between the parts as they were and as they are
template <class T>
void update_sliced_body(const StepParts &parts, const CutChanges &changes, SlicedPlan &plan, SlicedBody<T> &body);

} // namespace livermark::msm
