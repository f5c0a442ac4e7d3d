#include <cmath>

#include "msm/spring_law.hpp"

namespace livermark::msm::spring_curves {

/// energy = (ln s)^2 / 2: quadratic in Hencky's strain.
SpringCurve logarithmic() {
    return {.name = {},
            .summary = "force ln s / s at the stretch s",
            .source = "Hencky 1928, Z. Tech. Phys. 9",
            .curve = {
                .energy = [](double stretch) { return 0.5 * std::log(stretch) * std::log(stretch); },
                .force = [](double stretch) { return std::log(stretch) / stretch; },
                .slope = [](double stretch) { return (1.0 - std::log(stretch)) / (stretch * stretch); },
            }};
}

} // namespace livermark::msm::spring_curves
