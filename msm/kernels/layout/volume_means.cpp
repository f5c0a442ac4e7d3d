#include <algorithm>

#include "msm/elastic_body.hpp"
#include "msm/kernels/layout/slicing.hpp"
#include "msm/springs/tetrahedron_volume.hpp"

namespace livermark::msm {

std::vector<double> rest_volumes(const StepParts &parts, const Eigen::VectorXd &x) {
    std::vector<double> volumes;
    volumes.reserve(parts.tetrahedra.size());
    for (const auto &tetrahedron : parts.tetrahedra)
        volumes.push_back(volume_gradient(x, tetrahedron).volume);
    return volumes;
}

double rest_volume(const StepParts &parts, std::span<const double> volumes, std::span<const int> members) {
    double volume = 0.0;
    for (const int t : members)
        if (parts.is_there(t))
            volume += 0.25 * volumes[t];
    return volume;
}

std::vector<VolumeNeighbour> volume_mean(const StepParts &parts, std::span<const double> volumes, int volume,
                                         std::span<const int> members) {
    const double of_volume = rest_volume(parts, volumes, members);
    std::vector<VolumeNeighbour> shared;
    shared.reserve(members.size());
    for (const int t : members) {
        const double part = parts.is_there(t) ? volumes[t] / (16.0 * of_volume) : 0.0;
        for (const int other : parts.corner_volume[t]) {
            if (other == volume)
                continue;
            auto found = std::ranges::find(shared, other, &VolumeNeighbour::volume);
            if (found == shared.end())
                found = shared.insert(shared.end(), {other, 0.0});
            found->weight += part;
        }
    }
    std::ranges::sort(shared, {}, &VolumeNeighbour::volume);
    return shared;
}

VolumeMeans volume_means(const StepParts &parts, const std::vector<core::Vector3> &positions) {
    if (!parts.has_mean_volumes)
        return {};
    const auto volumes = rest_volumes(parts, to_unknowns(positions));
    const auto members = volume_members(parts);
    VolumeMeans means;
    for (int c = 0; c < static_cast<int>(parts.centre.size()); ++c)
        means.push_back(volume_mean(parts, volumes, c, members.of(c)));
    return means;
}

template <class T> void put_volume_mean(const std::vector<VolumeNeighbour> &mean, int number, SlicedBody<T> &body) {
    std::size_t at = static_cast<std::size_t>(body.mean_start[number / slice_size]) * slice_size + number % slice_size;
    for (const auto &neighbour : mean) {
        body.mean_weight[at] = static_cast<T>(neighbour.weight);
        at += slice_size;
    }
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
    for (std::size_t c = 0; c < means.size(); ++c)
        put_volume_mean(means[c], number_of_volume[c], body);
}

template void put_volume_mean(const std::vector<VolumeNeighbour> &, int, SlicedBody<float> &);
template void put_volume_mean(const std::vector<VolumeNeighbour> &, int, SlicedBody<double> &);
template void slice_volume_means(const VolumeMeans &, const std::vector<int> &, SlicedBody<float> &);
template void slice_volume_means(const VolumeMeans &, const std::vector<int> &, SlicedBody<double> &);

} // namespace livermark::msm
