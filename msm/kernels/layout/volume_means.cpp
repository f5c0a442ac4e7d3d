#include <map>

#include "msm/elastic_body.hpp"
#include "msm/kernels/layout/slicing.hpp"
#include "msm/springs/tetrahedron_volume.hpp"

namespace livermark::msm {

std::vector<double> rest_volumes(const StepParts &parts, const std::vector<core::Vector3> &positions) {
    const auto x = to_unknowns(positions);
    std::vector<double> volume(parts.centre.size(), 0.0);
    for (std::size_t t = 0; t < parts.tetrahedra.size(); ++t)
        for (const int c : parts.corner_volume[t])
            volume[c] += 0.25 * volume_gradient(x, parts.tetrahedra[t]).volume;
    return volume;
}

VolumeMeans volume_means(const StepParts &parts, const std::vector<core::Vector3> &positions) {
    if (!parts.has_mean_volumes)
        return {};
    const auto x = to_unknowns(positions);
    const auto volume = rest_volumes(parts, positions);
    std::vector<std::map<int, double>> shared(volume.size());
    for (std::size_t t = 0; t < parts.tetrahedra.size(); ++t) {
        const double of_tetrahedron = volume_gradient(x, parts.tetrahedra[t]).volume;
        for (const int c : parts.corner_volume[t])
            for (const int other : parts.corner_volume[t])
                if (c != other)
                    shared[c][other] += of_tetrahedron / (16.0 * volume[c]);
    }
    VolumeMeans means(volume.size());
    for (std::size_t c = 0; c < means.size(); ++c)
        for (const auto &[other, weight] : shared[c])
            means[c].push_back({other, weight});
    return means;
}

template <class T>
void slice_volume_means(const VolumeMeans &means, const std::vector<int> &number_of_volume, SlicedBody<T> &body) {
    if (means.empty())
        return;
    std::vector<std::vector<int>> neighbours(body.volume_row.size());
    for (std::size_t c = 0; c < means.size(); ++c)
        for (const auto &neighbour : means[c])
            neighbours[number_of_volume[c]].push_back(number_of_volume[neighbour.volume]);
    body.mean_start.assign(1, 0);
    append_lists(std::move(neighbours), 0, body.mean_start, body.mean_volume);
    body.mean_weight.assign(body.mean_volume.size(), T(0));
    for (std::size_t c = 0; c < means.size(); ++c) {
        const int number = number_of_volume[c];
        std::size_t at =
            static_cast<std::size_t>(body.mean_start[number / slice_size]) * slice_size + number % slice_size;
        for (const auto &neighbour : means[c]) {
            body.mean_weight[at] = static_cast<T>(neighbour.weight);
            at += slice_size;
        }
    }
}

template void slice_volume_means(const VolumeMeans &, const std::vector<int> &, SlicedBody<float> &);
template void slice_volume_means(const VolumeMeans &, const std::vector<int> &, SlicedBody<double> &);

} // namespace livermark::msm
