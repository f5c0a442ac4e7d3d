#include "msm/kernels/layout/mean_gradients.hpp"

#include <algorithm>

#include "msm/elastic_body.hpp"
#include "msm/springs/tetrahedron_volume.hpp"

namespace livermark::msm {

MeanGradient mean_gradient(const StepParts &parts, const Eigen::VectorXd &x, int volume, std::span<const int> members) {
    MeanGradient neighbours;
    double sum = 0.0; // of the volume
    for (const int t : members) {
        const auto &nodes = parts.tetrahedra[t];
        const auto of_tetrahedron = volume_gradient(x, nodes);
        const auto &gradient = of_tetrahedron.gradient; // V_t g_tj
        const double modulus = parts.inner_modulus[t] / of_tetrahedron.volume;
        const auto i = std::ranges::find(parts.corner_volume[t], volume) - parts.corner_volume[t].begin();
        const bool is_there = parts.is_there(t);
        if (is_there)
            sum += 0.25 * of_tetrahedron.volume;
        for (int j = 0; j < 4; ++j) {
            if (j == i)
                continue;
            auto found = std::ranges::find(neighbours, nodes[j], &NeighbourGradient::node);
            if (found == neighbours.end())
                found = neighbours.insert(neighbours.end(), {nodes[j], core::Vector3::Zero(), 0.0});
            if (!is_there)
                continue;
            found->gradient += 0.25 * gradient[j];
            found->stiffness -= modulus * gradient[i].dot(gradient[j]);
        }
    }
    std::ranges::sort(neighbours, {}, &NeighbourGradient::node);
    if (sum > 0.0)
        for (auto &neighbour : neighbours)
            neighbour.gradient /= sum;
    return neighbours;
}

std::vector<MeanGradient> mean_gradients(const StepParts &parts, const std::vector<core::Vector3> &positions) {
    if (!parts.has_gradient_means || parts.coupled_modulus.empty())
        return {};
    const auto x = to_unknowns(positions);
    const auto members = volume_members(parts);
    std::vector<MeanGradient> gradients;
    for (int c = 0; c < static_cast<int>(parts.centre.size()); ++c)
        gradients.push_back(mean_gradient(parts, x, c, members.of(c)));
    return gradients;
}

} // namespace livermark::msm
