#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "msm/kernels/layout/slicing.hpp"

/// How a sliced body is parted. Tetrahedra whose nodes change go from their places to a new chunk of fans; so do the
/// stars around their edges and the control volumes around their nodes. Lanes that they leave do nothing. Nodes keep
/// their rows, and new ones have rows behind them.
namespace livermark::msm {

/// Where rows are when some were put in before the copies.
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
    std::vector<int> of_volume; ///< the row of each new control volume
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

/// Takes tetrahedra and stars from their places to a new chunk of fans.
/// @param row_of_volume  shape (C)
/// @param plan           with positions of all nodes; told where tetrahedra and stars are
template <class T>
void add_chunk(const StepParts &parts, const PartingChanges &changes, std::span<const int> row_of_volume,
               SlicedPlan &plan, SlicedBody<T> &body, ForceSums<T> &sums);

/// What stands in SlicedBody::member where there is nothing.
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
