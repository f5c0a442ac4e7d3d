#include "msm/springs/springs_with_volume.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "msm/springs/inversion_guard.hpp"
#include "msm/springs/spring_network.hpp"
#include "support/known_names.hpp"

namespace livermark::msm {

core::Body for_springs_beside_volume(core::Body body) {
    for (auto &material : body.materials)
        material = {material.density, 2.5 * material.shear_modulus(), 0.25};
    return body;
}

core::SpringNetwork springs_beside_volume(const core::Body &body, const SpringLaw &law) {
    return spring_network(for_springs_beside_volume(body), law);
}

double modulus_beside_springs(const core::Material &material) {
    return material.lame_lambda() - material.shear_modulus();
}

bool needs_volume(const core::Body &body) {
    constexpr double rounding = 1e-12;
    return std::ranges::any_of(body.materials, [](const auto &material) {
        return std::abs(modulus_beside_springs(material)) > rounding * material.shear_modulus();
    });
}

std::shared_ptr<const ElasticTerm> volume_beside_springs(const core::Body &body, const VolumeTerm &term) {
    std::vector<double> modulus;
    std::ranges::transform(body.materials, std::back_inserter(modulus), modulus_beside_springs);
    return term.make(body, modulus);
}

MassSprings springs_with_volume(const core::Body &body, core::SpringNetwork springs, const VolumeTerm &term,
                                const ForceCurve &curve) {
    std::vector<std::shared_ptr<const ElasticTerm>> terms{spring_term(springs, curve)};
    if (needs_volume(body))
        terms.push_back(volume_beside_springs(body, term));
    terms.push_back(inversion_guard(body));
    ElasticBody elastic(springs.node_mass, std::move(terms));
    return {std::move(springs), std::move(elastic)};
}

const VolumeTerm &find_volume_term(std::string_view name) {
    return support::find_named(all_volume_terms(), std::string(name), "volume term");
}

} // namespace livermark::msm
