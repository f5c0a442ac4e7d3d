#include <numbers>

#include "msm/spring_law.hpp"

namespace livermark::msm::spring_laws {

namespace {

/// k_ij = sum over t at edge ij of (2 sqrt 2 / 25) l_t E_t   (Lloyd, Szekely, Harders 2007, IEEE TVCG 13(5))
/// with l_t the mean length of the six edges of the tetrahedron.
std::array<double, 6> edge_stiffness(const core::Body &body, std::size_t t) {
    constexpr double factor = 2.0 * std::numbers::sqrt2 / 25.0;
    const auto &mesh = body.mesh;
    double length = 0.0;
    for (const auto &[i, j] : core::tetrahedron_edges)
        length += (mesh.points[mesh.tetrahedra[t][j]] - mesh.points[mesh.tetrahedra[t][i]]).norm() / 6.0;
    std::array<double, 6> added{};
    added.fill(factor * length * body.young_modulus_of(t));
    return added;
}

} // namespace

SpringLaw lloyd_mean_edge() {
    return law_of_tetrahedra("Lloyd's formula with the mean edge of each tetrahedron",
                             "Lloyd, Szekely, Harders 2007, IEEE TVCG 13(5)", edge_stiffness);
}

} // namespace livermark::msm::spring_laws
