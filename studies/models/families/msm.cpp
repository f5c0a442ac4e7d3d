#include "msm/springs/spring_network.hpp"
#include "studies/models/mass_spring_model.hpp"

namespace livermark::models::families {

/// A mass-spring model per spring law, under the law's name: barycentric masses, springs on the edges of the mesh.
ModelFamily msm() {
    return {.name = {}, .models = [](const ModelOptions &options) {
                std::vector<core::Model> models;
                for (const auto &law : livermark::msm::all_spring_laws())
                    models.push_back(mass_spring_model(
                        law.name, law.summary, law.source,
                        [law](const core::Body &body) -> livermark::msm::MassSprings {
                            const auto springs = livermark::msm::spring_network(body, law);
                            return {springs, springs};
                        },
                        options));
                return models;
            }};
}

} // namespace livermark::models::families
