#include "msm/nodal_springs.hpp"

#include <fmt/format.h>

#include "models/mass_spring_model.hpp"

namespace livermark::models::families {

namespace {

core::Model nodal_springs_model(std::string name, const std::string &part_in_words, double part,
                                const ModelOptions &options) {
    return mass_spring_model(
        std::move(name),
        fmt::format("springs coupled to each other around each node, {} of their stiffness inside each tetrahedron, "
                    "with the volume around each node averaged with its neighbours'",
                    part_in_words),
        "Livermark; Delingette 2008, IEEE TVCG 14(2); Puso, Solberg 2006, Int. J. Numer. Meth. Engng. 67",
        [part](const core::Body &body) -> livermark::msm::MassSprings {
            auto springs = livermark::msm::nodal_springs_with_volume(body, part);
            return {{springs.node_mass, {}, {}, {}}, springs};
        },
        options);
}

} // namespace

/// Springs that are as good as any here, and with other values of their constant where the options say so.
ModelFamily nodal_springs() {
    return {.name = {}, .models = [](const ModelOptions &options) {
                std::vector<core::Model> models{
                    nodal_springs_model("nodal_springs", "a fifth", livermark::msm::nodal_springs_alone, options)};
                for (const double part : options.sweep_of("nodal_springs.a"))
                    models.push_back(nodal_springs_model(swept_name("nodal_springs.a", part), fmt::format("{}", part),
                                                         part, options));
                return models;
            }};
}

} // namespace livermark::models::families
