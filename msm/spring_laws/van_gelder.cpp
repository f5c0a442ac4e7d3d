#include "msm/spring_law.hpp"

namespace livermark::msm::spring_laws {

namespace {

/// k_ij = sum over t at edge ij of E_t V_t / l_ij^2   (Van Gelder 1998, J. Graphics Tools 3(2))
/// Each tetrahedron has sum of k l^2 = 6 E V = 15 mu V with mu = E / 2.5: the trace C_aabb V of the isotropic solid
/// with lambda = mu, Poisson's ratio 1/4, which is the only one that central springs can have.
std::vector<double> stiffness(const core::Body &body, const core::EdgeTable &table) {
    const auto &mesh = body.mesh;
    const auto volumes = core::tetrahedron_volumes(mesh);
    std::vector<double> stiffness(table.edges.size(), 0.0);
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        const double young_modulus = body.materials[mesh.region[t]].young_modulus;
        for (const int edge : table.tetrahedron_edge[t]) {
            const auto [i, j] = table.edges[edge];
            stiffness[edge] += young_modulus * volumes[t] / (mesh.points[j] - mesh.points[i]).squaredNorm();
        }
    }
    return stiffness;
}

} // namespace

SpringLaw van_gelder() {
    return {.name = {},
            .summary = "Van Gelder's formula, the volume around an edge over its length squared",
            .source = "Van Gelder 1998, J. Graphics Tools 3(2)",
            .stiffness = stiffness};
}

} // namespace livermark::msm::spring_laws
