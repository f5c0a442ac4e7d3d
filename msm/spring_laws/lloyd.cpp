#include <cmath>
#include <numbers>

#include "msm/spring_law.hpp"

namespace livermark::msm::spring_laws {

namespace {

/// k_ij = sum over t at edge ij of (2 sqrt 2 / 25) l_t E_t   (Lloyd, Szekely, Harders 2007, IEEE TVCG 13(5))
/// with l_t the edge of the regular tetrahedron of equal volume, l_t = (6 sqrt 2 V_t)^(1/3).
std::vector<double> stiffness(const core::Body &body, const core::EdgeTable &table) {
    constexpr double factor = 2.0 * std::numbers::sqrt2 / 25.0;
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    std::vector<double> stiffness(table.edges.size(), 0.0);
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        const double length = std::cbrt(6.0 * std::numbers::sqrt2 * volumes[t]);
        const double young_modulus = body.materials[body.mesh.region[t]].young_modulus;
        for (const int edge : table.tetrahedron_edge[t])
            stiffness[edge] += factor * length * young_modulus;
    }
    return stiffness;
}

} // namespace

SpringLaw lloyd() {
    return {.name = {},
            .summary = "Lloyd's formula with the edge of the regular tetrahedron of equal volume",
            .source = "Lloyd, Szekely, Harders 2007, IEEE TVCG 13(5)",
            .stiffness = stiffness};
}

} // namespace livermark::msm::spring_laws
