#include "results/records/needle.hpp"

#include <algorithm>
#include <cmath>

namespace livermark::results {

double NeedleRun::largest_force(const core::Needle &needle) const {
    // Until the surface gives way nothing of the shaft is inside: the hand bears what the tip exerts. NaN if it holds.
    double largest = insertion.puncture_depth <= insertion.depth[insertion.at_plan] ? needle.puncture_force : 0.0;
    for (int j = 0; j <= insertion.at_plan; ++j)
        largest = std::max(largest, insertion.force[j]);
    return largest;
}

void NeedleRun::note_limit(double largest_small) {
    for (int j = 0; j <= insertion.at_plan && std::isnan(left_regime_at); ++j)
        if (insertion.moved[j] > largest_small)
            left_regime_at = insertion.depth[j];
}

double NeedleRun::largest_pull() const {
    if (std::isnan(force_at_plan()))
        return force_at_plan();
    return std::max(0.0, -*std::min_element(insertion.force.begin() + insertion.at_plan, insertion.force.end()));
}

double NeedleRun::energy_error() const {
    const auto at_plan = static_cast<std::size_t>(insertion.at_plan);
    double largest = 0.0;
    for (std::size_t j = 0; j < insertion.work.size(); ++j) {
        const bool is_punctured = insertion.depth[j] >= insertion.puncture_depth || j >= at_plan;
        largest = std::max(largest, std::abs(insertion.work[j] - insertion.stored[j] - insertion.friction[j] -
                                             insertion.tearing[j] - insertion.holding[j] -
                                             (is_punctured ? insertion.puncture_loss : 0.0)));
    }
    return largest / insertion.work[at_plan];
}

double force_error(const core::Insertion &insertion, const core::Insertion &reference) {
    double difference = 0.0, size = 0.0;
    for (int j = 0; j <= reference.at_plan; ++j) {
        difference += std::pow(insertion.force[j] - reference.force[j], 2);
        size += std::pow(reference.force[j], 2);
    }
    return std::sqrt(difference / size);
}

} // namespace livermark::results
