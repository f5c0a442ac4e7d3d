#include "msm/mass_lumping.hpp"

namespace livermark::msm {

std::vector<double> lumped_masses(const core::Body &body) {
    const auto &mesh = body.mesh;
    const auto volumes = core::tetrahedron_volumes(mesh);
    std::vector<double> masses(mesh.points.size(), 0.0);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        for (const int node : mesh.tetrahedra[t])
            masses[node] += body.materials[mesh.region[t]].density * volumes[t] / 4.0;
    return masses;
}

} // namespace livermark::msm
