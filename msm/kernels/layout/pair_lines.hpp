#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "msm/kernels/layout/slicing.hpp"

namespace livermark::msm {

/// Where the lines of a pair of slices are filled up, at the end of which they are.
template <class T> class PairLines {
  public:
    /// On new lines behind those that are there.
    PairLines(const StepParts &parts, const LineCounts &count, SlicedBody<T> &body, SlicedPlan &plan)
        : parts_(parts), body_(body), plan_(plan) {
        lines_ = {static_cast<int>(body.neighbour.size()) / slice_size,
                  static_cast<int>(body.spring.size()) / (2 * slice_size), count};
        body.neighbour.resize(body.neighbour.size() + static_cast<std::size_t>(count.total()) * slice_size,
                              4 * body.num_rows);
        body.spring.resize(body.spring.size() + static_cast<std::size_t>(count.num_springs()) * 2 * slice_size, T(0));
    }

    /// On the lines of a pair that is there.
    PairLines(const StepParts &parts, const SpringLines &lines, SlicedBody<T> &body, SlicedPlan &plan)
        : parts_(parts), body_(body), plan_(plan), lines_(lines) {}

    /// Takes the springs of a lane from its lines.
    void clear(int lane) {
        for (int line = 0; line < lines_.count.total(); ++line)
            body_.neighbour[static_cast<std::size_t>(lines_.first_neighbour + line) * slice_size + lane] =
                4 * body_.num_rows;
        const std::size_t num_springs = 2 * static_cast<std::size_t>(lines_.count.num_springs()); // k, and k l0 / 2
        for (std::size_t line = 0; line < num_springs; ++line)
            body_.spring[(2 * static_cast<std::size_t>(lines_.first_spring) + line) * slice_size + lane] = T(0);
    }

    const SpringLines &lines() const { return lines_; }

    void fill(int number, const SpringLane &lane) {
        const auto &count = lines_.count;
        put_spring(lines_.first_spring, number, lane.between);
        int used = 0; // shared lines
        auto alone = lane.alone;
        for (const auto &n : lane.shared)
            if (used < count.shared) {
                put_shared(used++, number, n);
            } else {
                alone[0].push_back({n.node, {n.spring[0], padding}});
                alone[1].push_back({n.node, {padding, n.spring[1]}});
            }
        int line = count.shared, spring_line = lines_.first_spring + 1 + 2 * count.shared;
        for (const int side : {0, 1}) {
            for (std::size_t k = 0; k < alone[side].size(); ++k) {
                const auto &n = alone[side][k];
                const int own_line = static_cast<int>(k);
                if (own_line >= count.alone[side]) {
                    put_shared(used++, number, n);
                    continue;
                }
                put_neighbour(line + own_line, number, n.node);
                put_spring(spring_line + own_line, number, n.spring[side]);
            }
            line += count.alone[side];
            spring_line += count.alone[side];
        }
    }

  private:
    void put_shared(int line, int number, const LaneNeighbour &neighbour) {
        put_neighbour(line, number, neighbour.node);
        for (const int side : {0, 1})
            put_spring(lines_.first_spring + 1 + 2 * line + side, number, neighbour.spring[side]);
    }
    void put_neighbour(int line, int number, int node) {
        const std::size_t at = static_cast<std::size_t>(lines_.first_neighbour + line) * slice_size;
        body_.neighbour[at + number] = 4 * body_.row_of_node[node];
    }
    void put_spring(int line, int number, int spring) {
        if (spring == padding)
            return;
        const std::size_t at = static_cast<std::size_t>(line) * 2 * slice_size + number;
        msm::put_spring(parts_, spring, at, body_);
        auto &[first, last] = plan_.springs[spring];
        (first == no_place ? first : last) = at;
        if (last == no_place)
            last = at;
    }

    const StepParts &parts_;
    SlicedBody<T> &body_;
    SlicedPlan &plan_;
    SpringLines lines_;
};

} // namespace livermark::msm
