#include "msm/kernels/layout/mean_gradients.hpp"

#include <map>

#include "msm/elastic_body.hpp"
#include "msm/tetrahedron_volume.hpp"

namespace livermark::msm {

std::vector<MeanGradient> mean_gradients(const StepParts &parts, const std::vector<core::Vector3> &positions) {
    if (!parts.has_gradient_means)
        return {};
    const auto x = to_unknowns(positions);
    std::vector<std::map<int, core::Vector3>> sums(parts.centre.size());
    std::vector<double> volume(parts.centre.size(), 0.0);
    for (std::size_t t = 0; t < parts.tetrahedra.size(); ++t) {
        const auto &nodes = parts.tetrahedra[t];
        const auto of_tetrahedron = volume_gradient(x, nodes); // its gradients are V_t g_tj
        for (const int c : parts.corner_volume[t]) {
            volume[c] += 0.25 * of_tetrahedron.volume;
            for (int j = 0; j < 4; ++j)
                if (nodes[j] != parts.centre[c])
                    sums[c].try_emplace(nodes[j], core::Vector3::Zero()).first->second +=
                        0.25 * of_tetrahedron.gradient[j];
        }
    }
    std::vector<MeanGradient> gradients(sums.size());
    for (std::size_t c = 0; c < sums.size(); ++c)
        for (const auto &[node, sum] : sums[c])
            gradients[c].push_back({node, sum / volume[c]});
    return gradients;
}

} // namespace livermark::msm
