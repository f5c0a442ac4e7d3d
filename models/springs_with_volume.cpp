#include "models/springs_with_volume.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>
#include <utility>

#include "msm/inversion_guard.hpp"
#include "msm/spring_network.hpp"

namespace livermark::models {

core::SpringNetwork springs_beside_volume(const core::Body &body, const msm::SpringLaw &law) {
    auto spring_part = body;
    for (auto &material : spring_part.materials)
        material = {material.density, 2.5 * material.shear_modulus(), 0.25};
    return msm::spring_network(spring_part, law);
}

std::shared_ptr<const msm::ElasticTerm> volume_beside_springs(const core::Body &body, const msm::VolumeTerm &term) {
    std::vector<double> modulus;
    for (const auto &material : body.materials)
        modulus.push_back(material.lame_lambda() - material.shear_modulus());
    return term.make(body, modulus);
}

MassSprings springs_with_volume(const core::Body &body, core::SpringNetwork springs, const msm::VolumeTerm &term) {
    msm::ElasticBody elastic(
        springs.node_mass, {msm::spring_term(springs), volume_beside_springs(body, term), msm::inversion_guard(body)});
    return {std::move(springs), std::move(elastic)};
}

const msm::VolumeTerm &find_volume_term(std::string_view name) {
    const auto table = msm::all_volume_terms();
    const auto found = std::ranges::find(table, name, &msm::VolumeTerm::name);
    if (found == table.end())
        throw std::logic_error(fmt::format("there is no volume term {}", name));
    return *found;
}

} // namespace livermark::models
