#include "msm/dynamics/step_parts.hpp"

#include <algorithm>

namespace livermark::msm {

bool describe_volumes(const std::vector<int> &centre, const std::vector<std::array<int, 4>> &corner_volume,
                      StepParts &parts) {
    if (parts.centre.empty()) {
        parts.centre = centre;
        parts.corner_volume = corner_volume;
    }
    return parts.centre == centre && parts.corner_volume == corner_volume;
}

std::optional<StepParts> step_parts(const ElasticBody &body) {
    StepParts parts;
    const bool are_known = std::ranges::all_of(body.terms, [&](const auto &term) { return term->describe(parts); });
    const bool are_coupled_twice = !parts.coupled_modulus.empty() && !parts.shear_modulus.empty();
    return are_known && !are_coupled_twice ? std::optional(std::move(parts)) : std::nullopt;
}

} // namespace livermark::msm
