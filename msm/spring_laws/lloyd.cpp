#include <cmath>
#include <numbers>

#include "msm/spring_law.hpp"

namespace livermark::msm::spring_laws {

namespace {

/// k_ij = sum over t at edge ij of (2 sqrt 2 / 25) l_t E_t   (Lloyd, Szekely, Harders 2007, IEEE TVCG 13(5))
/// with l_t the edge of the regular tetrahedron of equal volume, l_t = (6 sqrt 2 V_t)^(1/3).
std::array<double, 6> edge_stiffness(const core::Body &body, std::size_t t) {
    constexpr double factor = 2.0 * std::numbers::sqrt2 / 25.0;
    const auto &points = body.mesh.points;
    const auto &[a, b, c, d] = body.mesh.tetrahedra[t];
    const double volume = core::signed_volume(points[a], points[b], points[c], points[d]);
    const double length = std::cbrt(6.0 * std::numbers::sqrt2 * volume);
    std::array<double, 6> added{};
    added.fill(factor * length * body.young_modulus_of(t));
    return added;
}

} // namespace

SpringLaw lloyd() {
    return law_of_tetrahedra("Lloyd's formula with the edge of the regular tetrahedron of equal volume",
                             "Lloyd, Szekely, Harders 2007, IEEE TVCG 13(5)", edge_stiffness);
}

} // namespace livermark::msm::spring_laws
