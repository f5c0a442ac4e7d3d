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

namespace {

/// Neo-Hookean springs keep strains and their rates apart, so the volume beside them has to do that too.
bool are_of_one_kind(const StepParts &parts) {
    const bool has_volume = !parts.volume_stiffness.empty();
    if (has_volume && parts.has_mean_volumes != !parts.edge_modulus.empty())
        return false;
    if (parts.coupled_energy != CoupledEnergy::neo_hookean)
        return !parts.has_logarithmic_volume;
    return parts.tetrahedron_stiffness.empty() && has_volume == parts.has_logarithmic_volume;
}

bool are_coupled_twice(const StepParts &parts) {
    return !parts.coupled_modulus.empty() && !parts.edge_modulus.empty();
}

} // namespace

std::optional<StepParts> step_parts(const ElasticBody &body) {
    StepParts parts;
    const bool are_known = std::ranges::all_of(body.terms, [&](const auto &term) { return term->describe(parts); });
    return are_known && !are_coupled_twice(parts) && are_of_one_kind(parts) ? std::optional(std::move(parts))
                                                                            : std::nullopt;
}

} // namespace livermark::msm
