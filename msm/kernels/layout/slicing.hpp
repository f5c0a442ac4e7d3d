#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "msm/elastic_body.hpp"
#include "msm/kernels/layout/sliced_body.hpp"

namespace livermark::msm {

/// Weights of the neighbours of a node i for springs that take the mean of the deformation gradient over a control
/// volume around it,
///     F = sum over neighbours j of (x_j - x_i) b_j^T,   b_j = sum over tetrahedra t with i and j of V_t / (4 V_i)
///     g_tj,
/// with the gradients g_tj of the barycentric coordinates at rest. These sum to zero in each tetrahedron, so x_i needs
/// none of its own. The part mu_t F of the stress inside tetrahedra is linear in positions too. It pulls i by
///     sum over neighbours j of k_j (x_j - x_i),   k_j = -sum over tetrahedra t with i and j of mu_t V_t g_ti . g_tj.
struct NeighbourGradient {
    int node;
    core::Vector3 gradient; ///< b_j [1/m]
    double stiffness;       ///< k_j [N/m]
};
using MeanGradient = std::vector<NeighbourGradient>;

/// Gradient of one control volume. Neighbours whose tetrahedra are all removed stay, with zeros.
/// @param x        shape (3N) [m], at rest
/// @param members  of the volume
MeanGradient mean_gradient(const StepParts &parts, const Eigen::VectorXd &x, int volume, std::span<const int> members);

/// @param positions  shape (N) [m], at rest
/// @return shape (C), each by ascending node numbers; empty if there are no springs that take means of F around nodes
std::vector<MeanGradient> mean_gradients(const StepParts &parts, const std::vector<core::Vector3> &positions);

// How lists of different lengths are put side by side in slices of 16 rows.

/// The number of what fills up a slice.
inline constexpr int padding = -1;

constexpr int padded(int count, int size = slice_size) {
    return (count + size - 1) / size * size;
}

/// Puts lists side by side, 16 to a slice, behind those that are there.
/// @param filler   what stands behind the end of a short list
/// @param offset   (slices + 1) where the entries of each begin, in units of 16; at first {0}
inline void append_lists(std::vector<std::vector<int>> lists, int filler, std::vector<int> &offset,
                         Aligned<std::int32_t> &entries) {
    lists.resize(padded(static_cast<int>(lists.size())));
    for (std::size_t first = 0; first < lists.size(); first += slice_size) {
        std::size_t longest = 0;
        for (std::size_t lane = 0; lane < slice_size; ++lane)
            longest = std::max(longest, lists[first + lane].size());
        const std::size_t at = entries.size();
        entries.resize(at + longest * slice_size, filler);
        offset.push_back(offset.back() + static_cast<int>(longest));
        for (std::size_t lane = 0; lane < slice_size; ++lane)
            for (std::size_t k = 0; k < lists[first + lane].size(); ++k)
                entries[at + k * slice_size + lane] = lists[first + lane][k];
    }
}

/// Which tetrahedron stands where on the lines, and which node stands where among the corners.
struct Lines {
    std::vector<int> tetrahedron; ///< number, padding where a fan is filled up
    std::vector<int> node;        ///< number; where a fan is filled up its last one, and padding in a fan of nothing
    std::vector<int> owner;       ///< a tetrahedron that the node belongs to there
};

/// Values of tetrahedra on the lines, and zeros where there is none.
template <class T> Aligned<T> on_lines(const std::vector<double> &values, const Lines &lines) {
    Aligned<T> result(values.empty() ? 0 : lines.tetrahedron.size(), T(0));
    for (std::size_t at = 0; at < result.size(); ++at)
        if (lines.tetrahedron[at] != padding)
            result[at] = static_cast<T>(values[lines.tetrahedron[at]]);
    return result;
}

/// Puts the neighbours of lanes and their springs on lines.
/// @param body  with all of its rows
/// @param plan  told where springs are
template <class T>
void slice_springs(const StepParts &parts, const std::vector<SpringLane> &lanes, SlicedBody<T> &body, SlicedPlan &plan);

/// A spring as it is now, at one of its places.
/// @param at  index into SlicedBody::spring
template <class T> void put_spring(const StepParts &parts, int spring, std::size_t at, SlicedBody<T> &body) {
    body.spring[at] = static_cast<T>(parts.stiffness[spring]);
    body.spring[at + slice_size] = static_cast<T>(0.5 * parts.stiffness[spring] * parts.rest_length[spring]);
}

/// The part of sliced_body() that tetrahedra have: fans, corner forces and volumes.
/// @param body  with its nodes
/// @param plan  told where tetrahedra, control volumes and edges are
template <class T>
void slice_tetrahedra(const StepParts &parts, const std::vector<core::Vector3> &positions, SlicedBody<T> &body,
                      SlicedPlan &plan);

/// The fans near each other, cut into chunks, and by falling length in each, so that those of a slice are alike.
/// @param body  with rows of nodes; told where chunks begin
/// @return whole slices, filled up with fans of nothing at the end of each chunk
template <class T> std::vector<Fan> fan_order(std::vector<Fan> fans, SlicedBody<T> &body);

/// @param body  told where fans begin
template <class T> Lines lines_of(const std::vector<Fan> &fans, SlicedBody<T> &body);

/// First of the corners of a slice of fans.
template <class T> std::size_t first_corner(const SlicedBody<T> &body, std::size_t fan_slice) {
    return (static_cast<std::size_t>(body.fan_start[fan_slice]) + 3 * fan_slice) * slice_size;
}

/// Makes of a tetrahedron on the lines one without volume.
/// @param place  on the lines
template <class T> void take_out(std::size_t place, SlicedBody<T> &body);

/// Shapes of tetrahedra at rest for springs that are coupled.
/// @param x  shape (3N) [m], at rest
template <class T>
void slice_shapes(const StepParts &parts, const Eigen::VectorXd &x, const Lines &lines, SlicedBody<T> &body);

/// Gives each node that a chunk touches a place to add forces to.
/// @param body  with fans; told where places are
/// @return shape (nodes and what fills up their slices), four times the places of each row
template <class T> std::vector<std::vector<int>> force_places(const Lines &lines, SlicedBody<T> &body);

/// Index of the row of no tetrahedron, in SlicedBody::edge_member.
template <class T> int filler_of_edges(const SlicedBody<T> &body) {
    return long_row(body.measure) * static_cast<int>(body.rest_volume.size());
}

/// Modulus and volume of an edge as they are now.
/// @param edge  of StepParts::edge_modulus
/// @param plan  with its lane and its tetrahedra
template <class T> void put_edge(const StepParts &parts, int edge, const SlicedPlan &plan, SlicedBody<T> &body);

/// The means of springs around edges, near each other those whose tetrahedra are.
/// @param plan  with places of tetrahedra; told those of edges
/// @param body  with its fans
template <class T> void slice_edges(const StepParts &parts, SlicedPlan &plan, SlicedBody<T> &body);

/// The control volumes around the neighbours of each one, and what part of their changes of volume it has in its own
/// mean, see mean_volumes_around_nodes().
struct VolumeNeighbour {
    int volume;
    double weight;
};
using VolumeMeans = std::vector<std::vector<VolumeNeighbour>>;

/// Neighbours of one control volume, ascending. Neighbours whose tetrahedra are all removed stay, with zeros.
/// @param volumes  of tetrahedra, from rest_volumes()
/// @param members  of the volume
std::vector<VolumeNeighbour> volume_mean(const StepParts &parts, std::span<const double> volumes, int volume,
                                         std::span<const int> members);

/// @return shape (C), empty if changes of volumes are not averaged
VolumeMeans volume_means(const StepParts &parts, const std::vector<core::Vector3> &positions);

/// @param number_of_volume  shape (C) which control volume of the sliced body it is
template <class T>
void slice_volume_means(const VolumeMeans &means, const std::vector<int> &number_of_volume, SlicedBody<T> &body);

/// The mean of one of them, on lines that are there.
template <class T> void put_volume_mean(const std::vector<VolumeNeighbour> &mean, int number, SlicedBody<T> &body);

/// Moduli of a control volume.
/// @param rest_volume  of the volume [m^3]
/// @param number       of the volume in the sliced body
template <class T>
void put_volume(const StepParts &parts, int volume, double rest_volume, int number, SlicedBody<T> &body);

/// Weights of the neighbours of a control volume, on lines that are there.
template <class T> void put_mean_gradient(const MeanGradient &gradient, int number, SlicedBody<T> &body);

/// The parts that springs coupled around nodes have, and what those around edges have besides their means.
/// @param positions         shape (N) [m], at rest
/// @param number_of_volume  shape (C) which control volume of the sliced body it is
/// @param gradients         shape (C), empty if no means of F are taken
/// @param places            shape (nodes and what fills up their slices), where forces on each are; more are added
template <class T>
void slice_nodal_springs(const StepParts &parts, const std::vector<core::Vector3> &positions,
                         const std::vector<int> &number_of_volume, const std::vector<MeanGradient> &gradients,
                         const Lines &lines, std::vector<std::vector<int>> &places, SlicedBody<T> &body);

// How a sliced body is parted. Tetrahedra whose nodes change go from their places to a new chunk of fans; so do the
// control volumes around their nodes. Lanes that they leave do nothing. Nodes keep their rows and edges their lanes,
// and new ones have rows and lanes behind them.

/// Places of rows when some were put in before the copies.
struct RowMap {
    int first_copy_before = 0, num_rows_before = 0, first_copy = 0, num_rows = 0;
    std::vector<int> copy; ///< of each copy before, which copy it is now

    bool are_copies_moved = false;

    bool is_identity() const {
        return first_copy == first_copy_before && num_rows == num_rows_before && !are_copies_moved;
    }
    int of(int row) const {
        if (row < first_copy_before)
            return row;
        const auto number = static_cast<std::size_t>(row - first_copy_before);
        return number < copy.size() ? first_copy + copy[number] : num_rows;
    }
};

struct NewRows {
    RowMap map;
    std::vector<int> volume_row; ///< the row of each new control volume
};

/// Gives new nodes rows, those that springs join in one lane, and new control volumes rows or copies.
/// @param plan  as before the parting; told which node is where
template <class T>
NewRows add_rows(const StepParts &parts, const PartingChanges &changes, SlicedPlan &plan, SlicedBody<T> &body);

/// Forces that rows have to sum from now on.
template <class T> class ForceSums {
  public:
    /// @param body  before it gets new places
    explicit ForceSums(const SlicedBody<T> &body)
        : end_of_chunks_(body.chunk_start.empty() ? 0 : body.chunk_start.back()), first_pull_(body.first_pull),
          num_pulls_(static_cast<int>(body.mean_node.size())) {}

    /// @param place  four times the place, as it is in the end
    void add(int row, int place) { added_.emplace_back(row, place); }

    /// Leaves out what a control volume puts down, which is no longer one.
    /// @param number  of the volume in the sliced body
    void leave_out_volume(int number) { left_out_.push_back(number); }

    /// @param rows  that may have places to leave out
    void look_at(int row) { looked_at_.push_back(row); }

    /// Puts the sums down.
    void finish(SlicedBody<T> &body) const;

  private:
    int end_of_chunks_, first_pull_, num_pulls_; ///< of the body before
    std::vector<std::pair<int, int>> added_;
    std::vector<int> left_out_, looked_at_;
};

/// Takes tetrahedra from their places to a new chunk of fans.
/// @param row_of_volume  shape (C)
/// @param plan           with positions of all nodes; told where tetrahedra are
template <class T>
void add_chunk(const StepParts &parts, const PartingChanges &changes, std::span<const int> row_of_volume,
               SlicedPlan &plan, SlicedBody<T> &body, ForceSums<T> &sums);

/// Puts the tetrahedra around edges on their lines again, where they are parted.
/// @param filler_before  filler_of_edges() before there was a new chunk
/// @param plan           with places of tetrahedra now; told where new edges are
template <class T>
void part_edges(const StepParts &parts, const PartingChanges &changes, int filler_before, SlicedPlan &plan,
                SlicedBody<T> &body);

/// Number in SlicedBody::member where there is nothing.
template <class T> int filler_of_members(const StepParts &parts, const SlicedBody<T> &body);

/// Puts the control volumes that have changed behind the others.
/// @param row_of_volume  shape (C)
/// @param filler_before  filler_of_members() before there was a new chunk
/// @param plan           with members of the volumes as they are now; told where volumes are
template <class T>
void add_volumes(const StepParts &parts, const PartingChanges &changes, std::span<const int> row_of_volume,
                 int filler_before, SlicedPlan &plan, SlicedBody<T> &body, ForceSums<T> &sums);

/// Puts the springs of pairs of slices on their lines again, in which nodes have lost springs or got some, and those
/// whose stiffness has changed.
template <class T>
void part_springs(const StepParts &parts, const PartingChanges &changes, SlicedPlan &plan, SlicedBody<T> &body);

/// Parts a sliced body: its motion is that of sliced_body() of the parts now. Sums have another order, and lanes from
/// which something was taken stay, so a step takes a little longer.
/// @param parts    as they are now
/// @param changes  what differs
/// @return where rows are now
template <class T>
RowMap part_sliced_body(const StepParts &parts, const PartingChanges &changes, SlicedPlan &plan, SlicedBody<T> &body);

} // namespace livermark::msm
