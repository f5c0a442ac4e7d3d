#include <fmt/format.h>

#include "models/mass_spring_model.hpp"
#include "msm/hyperelastic_springs.hpp"

namespace livermark::models::families {

namespace {

core::Model model(std::string name, const livermark::msm::SpringEnergy &energy, double part,
                  const ModelOptions &options) {
    return mass_spring_model(
        std::move(name),
        fmt::format("{} springs: their squared lengths coupled around each node and, with {} of the stiffness, inside "
                    "each tetrahedron, with the volume around each node",
                    energy.summary, part),
        fmt::format("Livermark; {}; Puso, Solberg 2006, Int. J. Numer. Meth. Engng. 67", energy.source),
        [energy, part](const core::Body &body) -> livermark::msm::MassSprings {
            auto springs = livermark::msm::hyperelastic_springs_with_volume(body, energy, part);
            return {{springs.node_mass, {}, {}, {}}, springs};
        },
        options);
}

} // namespace

/// Springs with the energy of a hyperelastic material, a model for each, under the name nodal_<energy>, and with other
/// values of their constant where the options say so.
ModelFamily hyperelastic_springs() {
    return {.name = {}, .models = [](const ModelOptions &options) {
                std::vector<core::Model> models;
                for (const auto &energy : livermark::msm::all_spring_energies()) {
                    const auto name = fmt::format("nodal_{}", energy.name);
                    const auto constant = name + ".a";
                    models.push_back(model(name, energy, livermark::msm::hyperelastic_springs_alone, options));
                    for (const double part : options.sweep_of(constant))
                        models.push_back(model(swept_name(constant, part), energy, part, options));
                }
                return models;
            }};
}

} // namespace livermark::models::families
