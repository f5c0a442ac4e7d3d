#include "msm/statics/limited_memory.hpp"

#include <utility>
#include <vector>

namespace livermark::msm {

Eigen::VectorXd LimitedMemory::times(const LinearMap &first, Eigen::VectorXd vector) const {
    std::vector<double> part(pairs_.size());
    for (std::size_t p = pairs_.size(); p-- > 0;) {
        part[p] = pairs_[p].step.dot(vector) / pairs_[p].curvature;
        vector -= part[p] * pairs_[p].change;
    }
    vector = first(vector);
    for (std::size_t p = 0; p < pairs_.size(); ++p)
        vector += (part[p] - pairs_[p].change.dot(vector) / pairs_[p].curvature) * pairs_[p].step;
    return vector;
}

void LimitedMemory::learn(Eigen::VectorXd step, Eigen::VectorXd change) {
    const double curvature = step.dot(change);
    if (curvature <= 0.0)
        return;
    if (pairs_.size() == most_steps_)
        pairs_.pop_front();
    pairs_.push_back({std::move(step), std::move(change), curvature});
}

} // namespace livermark::msm
