#include "msm/spring_law.hpp"

namespace livermark::msm::spring_laws {

namespace {

/// k_ij = sum over t at edge ij of E_t V_t / l_ij^2   (Van Gelder 1998, J. Graphics Tools 3(2))
/// Each tetrahedron has sum of k l^2 = 6 E V = 15 mu V with mu = E / 2.5: the trace C_aabb V of the isotropic solid
/// with lambda = mu, Poisson's ratio 1/4, which is the only one that central springs can have.
std::array<double, 6> edge_stiffness(const core::Body &body, std::size_t t) {
    const auto &points = body.mesh.points;
    const auto &nodes = body.mesh.tetrahedra[t];
    const double volume = core::signed_volume(points[nodes[0]], points[nodes[1]], points[nodes[2]], points[nodes[3]]);
    const double young_modulus = body.young_modulus_of(t);
    std::array<double, 6> added{};
    for (std::size_t e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        added[e] = young_modulus * volume / (points[nodes[j]] - points[nodes[i]]).squaredNorm();
    }
    return added;
}

} // namespace

SpringLaw van_gelder() {
    return law_of_tetrahedra("Van Gelder's formula, the volume around an edge over its length squared",
                             "Van Gelder 1998, J. Graphics Tools 3(2)", edge_stiffness);
}

} // namespace livermark::msm::spring_laws
