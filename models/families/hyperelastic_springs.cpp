#include <fmt/format.h>

#include "models/mass_spring_model.hpp"
#include "msm/hyperelastic_springs.hpp"

namespace livermark::models::families {

/// Springs with the energy of a hyperelastic material, a model for each, under the name nodal_<energy>.
ModelFamily hyperelastic_springs() {
    return {.name = {}, .models = [](const ModelOptions &options) {
                std::vector<core::Model> models;
                for (const auto &energy : livermark::msm::all_spring_energies())
                    models.push_back(mass_spring_model(
                        fmt::format("nodal_{}", energy.name),
                        fmt::format("{} springs: their squared lengths coupled around each node and inside each "
                                    "tetrahedron, with the volume around each node",
                                    energy.summary),
                        fmt::format("Livermark; {}; Puso, Solberg 2006, Int. J. Numer. Meth. Engng. 67", energy.source),
                        [energy](const core::Body &body) -> livermark::msm::MassSprings {
                            auto springs = livermark::msm::hyperelastic_springs_with_volume(body, energy);
                            return {{springs.node_mass, {}, {}, {}}, springs};
                        },
                        options));
                return models;
            }};
}

} // namespace livermark::models::families
