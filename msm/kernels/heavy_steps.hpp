#pragma once

#include <array>
#include <vector>

#include "msm/dynamics/mass_scaling.hpp"
#include "msm/kernels/step_workspace.hpp"

namespace livermark::msm {

/// What selective mass scaling makes of steps of symplectic Euler on vector units. The kernels take a step with the
/// masses as they are, v + h a and x + h (v + h a). This puts a scaled acceleration in the place of a, in double
/// precision.
template <class T> class HeavySteps {
  public:
    HeavySteps() = default;

    /// @param at  before its first step; its scheme is symplectic Euler
    HeavySteps(const MassScaling &scaling, const StepWorkspace<T> &at) {
        std::vector<std::vector<std::size_t>> copies(static_cast<std::size_t>(at.body.first_copy));
        for (std::size_t c = 0; c < at.body.copied_row.size(); ++c)
            copies[static_cast<std::size_t>(at.body.copied_row[c])].push_back(
                static_cast<std::size_t>(at.body.first_copy) + c);
        for (const auto &scaled : scaling.parts) {
            const auto size = static_cast<Eigen::Index>(scaled.nodes.size());
            auto &part = parts_.emplace_back(Part{.scaled = scaled,
                                                  .rows = {},
                                                  .before = Eigen::Matrix3Xd(3, size),
                                                  .gain = Eigen::Matrix3Xd(3, size),
                                                  .change = Eigen::Matrix3Xd(3, size),
                                                  .start = Eigen::Matrix3Xd(3, size)});
            for (const int node : scaled.nodes) {
                const auto row = static_cast<std::size_t>(at.body.row_of_node[node]);
                part.rows.push_back({row});
                part.rows.back().insert(part.rows.back().end(), copies[row].begin(), copies[row].end());
            }
        }
    }

    bool empty() const { return parts_.empty(); }

    /// Before a step.
    void remember(const StepWorkspace<T> &at) {
        for (auto &part : parts_)
            for (std::size_t i = 0; i < part.rows.size(); ++i)
                part.before.col(static_cast<Eigen::Index>(i)) = get(at, part.rows[i].front(), &NodeSlice<T>::velocity);
    }

    /// After it.
    void correct(StepWorkspace<T> &at) {
        for (auto &part : parts_) {
            for (std::size_t i = 0; i < part.rows.size(); ++i) {
                const auto column = static_cast<Eigen::Index>(i);
                const auto row = part.rows[i].front();
                const core::Vector3 velocity = get(at, row, &NodeSlice<T>::velocity);
                part.gain.col(column) = velocity - part.before.col(column);
                part.start.col(column) = get(at, row, &NodeSlice<T>::position) - at.time_step * velocity;
            }
            part.change = part.gain / at.time_step;
            scale_acceleration(part.scaled, part.start, part.before, part.change);
            part.change = at.time_step * part.change - part.gain;
            for (std::size_t i = 0; i < part.rows.size(); ++i) {
                const core::Vector3 change = part.change.col(static_cast<Eigen::Index>(i));
                add(at, part.rows[i], &NodeSlice<T>::velocity, change, at.velocity_rows[at.now]);
                add(at, part.rows[i], &NodeSlice<T>::position, at.time_step * change, at.rows[at.now]);
            }
        }
    }

  private:
    struct Part {
        HeavyPart scaled;
        std::vector<std::vector<std::size_t>> rows;   ///< of each node, with its copies
        Eigen::Matrix3Xd before, gain, change, start; ///< velocities, and where a step starts
    };

    static core::Vector3 get(const StepWorkspace<T> &at, std::size_t row, FineField<T> NodeSlice<T>::*field) {
        const auto &of_slice = at.nodes[row / slice_size].*field;
        const std::size_t lane = row % slice_size;
        return {of_slice.get(0, lane), of_slice.get(1, lane), of_slice.get(2, lane)};
    }

    static void add(StepWorkspace<T> &at, const std::vector<std::size_t> &rows, FineField<T> NodeSlice<T>::*field,
                    const core::Vector3 &change, Aligned<T> &fetched) {
        auto &of_slice = at.nodes[rows.front() / slice_size].*field;
        const std::size_t lane = rows.front() % slice_size;
        for (std::size_t c = 0; c < 3; ++c) {
            of_slice.set(c, lane, of_slice.get(c, lane) + change[static_cast<Eigen::Index>(c)]);
            if (!fetched.empty())
                for (const auto row : rows)
                    fetched[4 * row + c] = of_slice.high[c][lane];
        }
    }

    std::vector<Part> parts_;
};

} // namespace livermark::msm
