#include <algorithm>

#include "msm/kernels/layout/pair_lines.hpp"

namespace livermark::msm {

template <class T>
void slice_springs(const StepParts &parts, const std::vector<SpringLane> &lanes, SlicedBody<T> &body,
                   SlicedPlan &plan) {
    plan.springs.assign(parts.edges.size(), {no_place, no_place});
    for (std::size_t first = 0; first < lanes.size(); first += slice_size) {
        const std::size_t last = std::min(first + slice_size, lanes.size());
        PairLines<T> lines(parts, fewest_lines(lanes, first, last), body, plan);
        for (std::size_t l = first; l < last; ++l)
            lines.fill(static_cast<int>(l - first), lanes[l]);
        body.spring_lines.push_back(lines.lines());
    }
}

template void slice_springs(const StepParts &, const std::vector<SpringLane> &, SlicedBody<float> &, SlicedPlan &);
template void slice_springs(const StepParts &, const std::vector<SpringLane> &, SlicedBody<double> &, SlicedPlan &);

} // namespace livermark::msm
