#include "interactive/elements/critical_step.hpp"

#include <algorithm>
#include <cmath>

#include "interactive/elements/element_energy.hpp"

namespace livermark::interactive {

double critical_time_step(const std::vector<Tetrahedron> &tetrahedra, const std::vector<double> &node_mass) {
    std::vector<double> node_volume(node_mass.size(), 0.0);
    for (const auto &t : tetrahedra)
        for (const int node : t.nodes)
            node_volume[node] += t.volume;
    double highest = 0.0;
    for (const auto &t : tetrahedra) {
        const auto gradients = t.shape_gradients();
        Eigen::Matrix<double, 12, 9> strain; // dF of unit moves, over the roots of masses
        for (int a = 0; a < 4; ++a) {
            const double mass = node_mass[t.nodes[a]] * t.volume / node_volume[t.nodes[a]];
            for (int j = 0; j < 3; ++j)
                strain.block<3, 3>(3 * a, 3 * j) = gradients(a, j) / std::sqrt(mass) * Matrix3::Identity();
        }
        const densities::Tangent tangent = densities::NeoHookean{t.mu, t.lambda}.tangent(Matrix3::Identity());
        const Eigen::Matrix<double, 12, 12> matrix = t.volume * strain * tangent * strain.transpose();
        highest = std::max(highest,
                           Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 12, 12>>(matrix, Eigen::EigenvaluesOnly)
                               .eigenvalues()
                               .maxCoeff());
    }
    return 2.0 / std::sqrt(highest);
}

} // namespace livermark::interactive
