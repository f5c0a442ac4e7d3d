#include "results/records/needle_arena.hpp"

#include <algorithm>

namespace livermark::results {

NeedleForces needle_forces(const std::vector<double> &depth, const std::vector<double> &force, int at_plan) {
    NeedleForces found;
    found.peak = *std::max_element(force.begin(), force.begin() + at_plan + 1);
    found.pull = std::max(0.0, -*std::min_element(force.begin() + at_plan, force.end()));
    const int from = at_plan / 2, count = at_plan + 1 - from;
    double mean_depth = 0.0, mean_force = 0.0;
    for (int j = from; j <= at_plan; ++j) {
        mean_depth += depth[j] / count;
        mean_force += force[j] / count;
    }
    double together = 0.0, square = 0.0;
    for (int j = from; j <= at_plan; ++j) {
        together += (depth[j] - mean_depth) * (force[j] - mean_force);
        square += (depth[j] - mean_depth) * (depth[j] - mean_depth);
    }
    found.slope = together / square;
    return found;
}

} // namespace livermark::results
