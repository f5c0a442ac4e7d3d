#include "core/mesh/tetra_mesh.hpp"
#include "models/mass_spring_model.hpp"
#include "msm/mass_lumping.hpp"
#include "msm/springs/biquadratic_springs.hpp"

namespace livermark::models::families {

/// The upper end of what springs on a mesh can be.
ModelFamily biquadratic() {
    return {.name = {}, .models = [](const ModelOptions &options) {
                return std::vector<core::Model>{mass_spring_model(
                    "biquadratic_springs",
                    "springs coupled to each other inside each tetrahedron: linear tetrahedra of Saint Venant and "
                    "Kirchhoff",
                    "Delingette 2008, IEEE TVCG 14(2)",
                    [](const core::Body &body) -> livermark::msm::MassSprings {
                        auto mass = livermark::msm::lumped_masses(body);
                        return {{mass, {}, {}, {}}, {mass, {livermark::msm::biquadratic_springs(body)}}};
                    },
                    options)};
            }};
}

} // namespace livermark::models::families
