#include <numbers>

#include "msm/spring_law.hpp"

namespace livermark::msm::spring_laws {

namespace {

/// k_ij = sum over t at edge ij of (2 sqrt 2 / 25) l_ij E_t   (Lloyd, Szekely, Harders 2007, IEEE TVCG 13(5))
/// with l_ij the length of the edge itself.
std::array<double, 6> edge_stiffness(const core::Body &body, std::size_t t) {
    constexpr double factor = 2.0 * std::numbers::sqrt2 / 25.0;
    const auto &mesh = body.mesh;
    const double young_modulus = body.young_modulus_of(t);
    std::array<double, 6> added{};
    for (std::size_t e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        const core::Vector3 span = mesh.points[mesh.tetrahedra[t][j]] - mesh.points[mesh.tetrahedra[t][i]];
        added[e] = factor * span.norm() * young_modulus;
    }
    return added;
}

} // namespace

SpringLaw lloyd_edge() {
    return law_of_tetrahedra("Lloyd's formula with the actual length of each edge",
                             "Lloyd, Szekely, Harders 2007, IEEE TVCG 13(5)", edge_stiffness);
}

} // namespace livermark::msm::spring_laws
