#include "live/material.hpp"

#include <algorithm>
#include <vector>

namespace livermark::live {

int largest_region(const core::TetraMesh &mesh) {
    std::vector<double> volume(mesh.region_names.size(), 0.0);
    const auto volumes = core::tetrahedron_volumes(mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        volume[mesh.region[t]] += volumes[t];
    return static_cast<int>(std::ranges::max_element(volume) - volume.begin());
}

core::Body with_material(core::Body body, double young_modulus, double poisson_ratio) {
    const double factor = young_modulus / body.materials[largest_region(body.mesh)].young_modulus;
    for (auto &material : body.materials) {
        material.young_modulus *= factor;
        material.poisson_ratio = poisson_ratio;
    }
    return body;
}

} // namespace livermark::live
