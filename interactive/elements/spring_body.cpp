#include "interactive/elements/spring_body.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace livermark::interactive {

Springs springs_with_shear_modulus(const core::Body &body) {
    return springs_with_shear_modulus(body, core::edge_table(body.mesh.tetrahedra));
}

Springs springs_with_shear_modulus(const core::Body &body, const core::EdgeTable &table) {
    constexpr double factor = 2.0 * std::numbers::sqrt2 / 25.0, young_over_shear = 2.5;
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    Springs springs{table.edges, std::vector<double>(table.edges.size(), 0.0), {}};
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        const double length = std::cbrt(6.0 * std::numbers::sqrt2 * volumes[t]);
        const double young_modulus = young_over_shear * body.materials[body.mesh.region[t]].shear_modulus();
        for (const int edge : table.tetrahedron_edge[t])
            springs.stiffness[edge] += factor * length * young_modulus;
    }
    for (const auto &[a, b] : springs.edges)
        springs.rest_length.push_back((body.mesh.points[a] - body.mesh.points[b]).norm());
    return springs;
}

SpringEnergy::SpringEnergy(Springs springs) : springs_(std::move(springs)) {}

double SpringEnergy::value(const Field &x) const {
    double value = 0.0;
    for (std::size_t s = 0; s < springs_.edges.size(); ++s) {
        const auto &[a, b] = springs_.edges[s];
        const double stretch = (x.col(a) - x.col(b)).norm() - springs_.rest_length[s];
        value += 0.5 * springs_.stiffness[s] * stretch * stretch;
    }
    return value;
}

void SpringEnergy::add_forces(const Field &x, Field &f) const {
    for (std::size_t s = 0; s < springs_.edges.size(); ++s) {
        const auto &[a, b] = springs_.edges[s];
        const core::Vector3 d = x.col(a) - x.col(b);
        const core::Vector3 force = springs_.stiffness[s] * (1.0 - springs_.rest_length[s] / d.norm()) * d;
        f.col(a) -= force;
        f.col(b) += force;
    }
}

void SpringEnergy::add_hessian(const Field &x, bool is_projected, Triplets &triplets) const {
    for (std::size_t s = 0; s < springs_.edges.size(); ++s) {
        const auto &edge = springs_.edges[s];
        const core::Vector3 d = x.col(edge[0]) - x.col(edge[1]);
        const core::Vector3 along = d.normalized();
        double across = 1.0 - springs_.rest_length[s] / d.norm();
        if (is_projected)
            across = std::max(across, 0.0);
        const Matrix3 block =
            springs_.stiffness[s] * (across * Matrix3::Identity() + (1.0 - across) * along * along.transpose());
        for (int a = 0; a < 2; ++a)
            for (int b = 0; b < 2; ++b)
                for (int i = 0; i < 3; ++i)
                    for (int k = 0; k < 3; ++k)
                        triplets.emplace_back(3 * edge[a] + i, 3 * edge[b] + k, (a == b ? 1.0 : -1.0) * block(i, k));
    }
}

SpringAndVolumeEnergy::SpringAndVolumeEnergy(const core::Body &body, const core::EdgeTable &edges)
    : springs_(springs_with_shear_modulus(body, edges)), volumes_(tetrahedra_at_rest(body)) {}

} // namespace livermark::interactive
