#include <numbers>

#include "msm/spring_law.hpp"

namespace livermark::msm::spring_laws {

namespace {

/// k_ij = sum over t at edge ij of (2 sqrt 2 / 25) l_t E_t   (Lloyd, Szekely, Harders 2007, IEEE TVCG 13(5))
/// with l_t the mean length of the six edges of the tetrahedron.
std::vector<double> stiffness(const core::Body &body, const core::EdgeTable &table) {
    constexpr double factor = 2.0 * std::numbers::sqrt2 / 25.0;
    const auto &mesh = body.mesh;
    std::vector<double> stiffness(table.edges.size(), 0.0);
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        double length = 0.0;
        for (const int edge : table.tetrahedron_edge[t]) {
            const auto [i, j] = table.edges[edge];
            length += (mesh.points[j] - mesh.points[i]).norm() / 6.0;
        }
        const double young_modulus = body.materials[mesh.region[t]].young_modulus;
        for (const int edge : table.tetrahedron_edge[t])
            stiffness[edge] += factor * length * young_modulus;
    }
    return stiffness;
}

} // namespace

SpringLaw lloyd_mean_edge() {
    return {.name = {},
            .summary = "Lloyd's formula with the mean edge of each tetrahedron",
            .source = "Lloyd, Szekely, Harders 2007, IEEE TVCG 13(5)",
            .stiffness = stiffness};
}

} // namespace livermark::msm::spring_laws
