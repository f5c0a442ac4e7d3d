#include "msm/springs/springs.hpp"

#include <fmt/format.h>

#include "studies/models/model_table.hpp"

namespace livermark::models::families {

namespace {

using livermark::msm::CoupledSprings;
using livermark::msm::StrainMeasure;

std::string in_words(const CoupledSprings &springs) {
    const auto &[nodes, edges, tetrahedra] = springs.domains;
    std::string measure = "elongations";
    if (springs.measure != StrainMeasure::elongation)
        measure =
            springs.measure == StrainMeasure::cauchy_green ? "the Cauchy-Green tensor" : "the deformation gradient";
    return fmt::format(
        "springs coupled around each {}, {:g} of their stiffness inside each tetrahedron: {} of means of "
        "{}, with {}the volume around each node",
        nodes > 0.0 ? "node" : "edge", tetrahedra, springs.energy.summary, measure,
        springs.averages_volumes ? "means of " : "");
}

core::Model model(const CoupledSprings &springs, std::string name, const ModelOptions &options) {
    return mass_spring_model(
        std::move(name), in_words(springs),
        fmt::format("Livermark; {}; {}", springs.energy.source,
                    springs.domains.nodes > 0.0 ? "Puso, Solberg 2006, Int. J. Numer. Meth. Engng. 67"
                                                : "Liu, Nguyen-Thoi, Lam 2009, J. Sound Vib. 320"),
        [springs](const core::Body &body) -> livermark::msm::MassSprings {
            auto made = livermark::msm::coupled_springs_with_volume(body, springs);
            return {{made.node_mass, {}, {}, {}}, made};
        },
        options);
}

} // namespace

/// Springs that are coupled to each other, and with other parts of their stiffness inside tetrahedra where the options
/// say so.
ModelFamily coupled_springs() {
    return {.name = {}, .models = [](const ModelOptions &options) {
                std::vector<core::Model> models;
                for (const auto &springs : livermark::msm::all_coupled_springs()) {
                    const auto constant = springs.name + ".a";
                    models.push_back(model(springs, springs.name, options));
                    models.back().only_when_named =
                        springs.domains.edges > 0.0 || !livermark::msm::are_in_kernels(springs);
                    for (const double part : options.sweep_of(constant))
                        models.push_back(model(livermark::msm::with_part_inside(springs, part),
                                               swept_name(constant, part), options));
                }
                return models;
            }};
}

} // namespace livermark::models::families
