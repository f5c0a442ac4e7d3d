#include "msm/kernels/layout/mean_gradients.hpp"

#include <map>

#include "msm/elastic_body.hpp"
#include "msm/springs/tetrahedron_volume.hpp"

namespace livermark::msm {

std::vector<MeanGradient> mean_gradients(const StepParts &parts, const std::vector<core::Vector3> &positions) {
    if (!parts.has_gradient_means || parts.coupled_modulus.empty())
        return {};
    const auto x = to_unknowns(positions);
    std::vector<std::map<int, NeighbourGradient>> neighbours(parts.centre.size());
    std::vector<double> volume(parts.centre.size(), 0.0);
    for (std::size_t t = 0; t < parts.tetrahedra.size(); ++t) {
        const auto &nodes = parts.tetrahedra[t];
        const auto of_tetrahedron = volume_gradient(x, nodes);
        const auto &gradient = of_tetrahedron.gradient; // V_t g_tj
        const double modulus = parts.inner_modulus[t] / of_tetrahedron.volume;
        for (int i = 0; i < 4; ++i) {
            const int c = parts.corner_volume[t][i];
            volume[c] += 0.25 * of_tetrahedron.volume;
            for (int j = 0; j < 4; ++j)
                if (j != i) {
                    auto &sum = neighbours[c].try_emplace(nodes[j], nodes[j], core::Vector3::Zero(), 0.0).first->second;
                    sum.gradient += 0.25 * gradient[j];
                    sum.stiffness -= modulus * gradient[i].dot(gradient[j]);
                }
        }
    }
    std::vector<MeanGradient> gradients(neighbours.size());
    for (std::size_t c = 0; c < neighbours.size(); ++c)
        for (auto [node, of_neighbour] : neighbours[c]) {
            of_neighbour.gradient /= volume[c];
            gradients[c].push_back(of_neighbour);
        }
    return gradients;
}

} // namespace livermark::msm
