#include <algorithm>
#include <limits>

#include "msm/kernels/layout/slicing.hpp"

namespace livermark::msm {

namespace {

constexpr std::size_t unknown = std::numeric_limits<std::size_t>::max();

/// Where the lines of a pair of slices are filled up, at the end of which they are.
template <class T> class PairLines {
  public:
    PairLines(const StepParts &parts, const LineCounts &count, SlicedBody<T> &body, SlicedPlan &plan)
        : parts_(parts), body_(body), plan_(plan) {
        lines_ = {static_cast<int>(body.neighbour.size()) / slice_size,
                  static_cast<int>(body.spring.size()) / (2 * slice_size), count};
        body.neighbour.resize(body.neighbour.size() + static_cast<std::size_t>(count.total()) * slice_size,
                              4 * body.num_rows);
        body.spring.resize(body.spring.size() + static_cast<std::size_t>(count.num_springs()) * 2 * slice_size, T(0));
        body.spring_lines.push_back(lines_);
    }

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
        (first == unknown ? first : last) = at;
        if (last == unknown)
            last = at;
    }

    const StepParts &parts_;
    SlicedBody<T> &body_;
    SlicedPlan &plan_;
    SpringLines lines_;
};

} // namespace

template <class T>
void slice_springs(const StepParts &parts, const std::vector<SpringLane> &lanes, SlicedBody<T> &body,
                   SlicedPlan &plan) {
    plan.springs.assign(parts.edges.size(), {unknown, unknown});
    for (std::size_t first = 0; first < lanes.size(); first += slice_size) {
        const std::size_t last = std::min(first + slice_size, lanes.size());
        PairLines<T> lines(parts, fewest_lines(lanes, first, last), body, plan);
        for (std::size_t l = first; l < last; ++l)
            lines.fill(static_cast<int>(l - first), lanes[l]);
    }
}

template void slice_springs(const StepParts &, const std::vector<SpringLane> &, SlicedBody<float> &, SlicedPlan &);
template void slice_springs(const StepParts &, const std::vector<SpringLane> &, SlicedBody<double> &, SlicedPlan &);

} // namespace livermark::msm
