#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <stdexcept>
#include <string_view>

#include "models/mass_spring_model.hpp"
#include "msm/inversion_guard.hpp"
#include "msm/spring_network.hpp"
#include "msm/volume_term.hpp"

namespace livermark::models::families {

namespace {

/// Springs are a solid with lambda = mu, and take its Young's modulus 5 mu / 2 and Poisson's ratio 1/4.
core::Body spring_part(core::Body body) {
    for (auto &material : body.materials)
        material = {material.density, 2.5 * material.shear_modulus(), 0.25};
    return body;
}

/// What is left of lambda.
std::vector<double> volume_part(const core::Body &body) {
    std::vector<double> modulus;
    for (const auto &material : body.materials)
        modulus.push_back(material.lame_lambda() - material.shear_modulus());
    return modulus;
}

core::Model model(const msm::SpringLaw &law, const msm::VolumeTerm &term, const ModelOptions &options) {
    return mass_spring_model(
        fmt::format("{}_{}", law.name, term.name), fmt::format("{}, with {}", law.summary, term.summary),
        fmt::format("{}; {}", law.source, term.source),
        [law, term](const core::Body &body) -> MassSprings {
            auto springs = msm::spring_network(spring_part(body), law);
            msm::ElasticBody elastic(springs.node_mass, {msm::spring_term(springs), term.make(body, volume_part(body)),
                                                         msm::inversion_guard(body)});
            return {std::move(springs), std::move(elastic)};
        },
        options);
}

template <class Entry> const Entry &find(std::span<const Entry> table, std::string_view name) {
    const auto found = std::ranges::find(table, name, &Entry::name);
    if (found == table.end())
        throw std::logic_error(fmt::format("there is no {}", name));
    return *found;
}

/// Not every pair is worth its time in a run over everything.
constexpr std::array<std::array<std::string_view, 2>, 4> pairs{{
    {"lloyd", "nodal_volume"},
    {"patch", "nodal_volume"},
    {"van_gelder", "nodal_volume"},
    {"van_gelder", "tetrahedral_volume"},
}};

} // namespace

/// Springs that carry lambda = mu of the material, and a volume term that carries the rest, so that any Poisson's ratio
/// can be had; under the name <law>_<volume term>. Tetrahedra are kept from turning inside out.
ModelFamily msm_volume() {
    return {.name = {}, .models = [](const ModelOptions &options) {
                std::vector<core::Model> models;
                for (const auto &[law, term] : pairs)
                    models.push_back(model(find(livermark::msm::all_spring_laws(), law),
                                           find(livermark::msm::all_volume_terms(), term), options));
                return models;
            }};
}

} // namespace livermark::models::families
