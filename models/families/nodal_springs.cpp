#include "msm/nodal_springs.hpp"
#include "models/mass_spring_model.hpp"

namespace livermark::models::families {

/// Springs that are as good as any here.
ModelFamily nodal_springs() {
    return {
        .name = {}, .models = [](const ModelOptions &options) {
            return std::vector<core::Model>{mass_spring_model(
                "nodal_springs",
                "springs coupled to each other around each node, a fifth of their stiffness inside each tetrahedron, "
                "with the volume around each node averaged with its neighbours'",
                "Livermark; Delingette 2008, IEEE TVCG 14(2); Puso, Solberg 2006, Int. J. Numer. Meth. Engng. 67",
                [](const core::Body &body) -> livermark::msm::MassSprings {
                    auto springs = livermark::msm::nodal_springs_with_volume(body);
                    return {{springs.node_mass, {}, {}, {}}, springs};
                },
                options)};
        }};
}

} // namespace livermark::models::families
