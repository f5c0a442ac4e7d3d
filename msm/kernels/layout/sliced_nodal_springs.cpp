#include <algorithm>
#include <array>
#include <tuple>
#include <type_traits>
#include <utility>

#include "msm/elastic_body.hpp"
#include "msm/kernels/layout/slicing.hpp"
#include "msm/springs/tetrahedron.hpp"

namespace livermark::msm {

MeanGradient mean_gradient(const StepParts &parts, const Eigen::VectorXd &x, int volume, std::span<const int> members) {
    MeanGradient neighbours;
    double sum = 0.0; // of the volume
    for (const int t : members) {
        const auto &nodes = parts.tetrahedra[t];
        const auto tetrahedron = volume_gradient(x, nodes);
        const auto &gradient = tetrahedron.gradient; // V_t g_tj
        const double modulus = parts.inner_modulus[t] / tetrahedron.volume;
        const auto i = std::ranges::find(parts.corner_volume[t], volume) - parts.corner_volume[t].begin();
        const bool is_there = parts.is_there(t);
        if (is_there)
            sum += 0.25 * tetrahedron.volume;
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
    if (parts.measure != StrainMeasure::deformation_gradient || parts.coupled_modulus.empty())
        return {};
    const auto x = to_unknowns(positions);
    const auto members = volume_members(parts);
    std::vector<MeanGradient> gradients;
    for (int c = 0; c < static_cast<int>(parts.centre.size()); ++c)
        gradients.push_back(mean_gradient(parts, x, c, members.of(c)));
    return gradients;
}

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
    const double own = rest_volume(parts, volumes, members);
    std::vector<VolumeNeighbour> shared;
    shared.reserve(members.size());
    for (const int t : members) {
        const double part = parts.is_there(t) ? volumes[t] / (16.0 * own) : 0.0;
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
    if (!parts.averages_volumes)
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

namespace {

/// Gradients of the barycentric coordinates of the last three of four corners, as in SlicedBody::rest_gradient.
std::array<double, 9> gradients(const Eigen::VectorXd &x, const std::array<int, 4> &nodes) {
    const auto [volume, gradient] = volume_gradient(x, nodes);
    std::array<double, 9> values{};
    for (std::size_t k = 0; k < values.size(); ++k)
        values[k] = gradient[1 + k / 3][static_cast<Eigen::Index>(k % 3)] / volume;
    return values;
}

/// As in SlicedBody::rest_length.
std::array<double, 6> lengths(const Eigen::VectorXd &x, const std::array<int, 4> &nodes) {
    const auto between = [&](int a, int b) { return (node_part(x, nodes[b]) - node_part(x, nodes[a])).norm(); };
    return {between(0, 1), between(0, 2), between(0, 3), between(1, 2), between(2, 3), between(3, 1)};
}

/// Several values of each tetrahedron on the lines, one behind the other, and zeros where there is none.
template <class T, class ValuesOf>
Aligned<T> values_on_lines(const Lines &lines, const SlicedBody<T> &body, const ValuesOf &values_of) {
    constexpr std::size_t num_values = std::tuple_size_v<std::invoke_result_t<ValuesOf, std::array<int, 4>>>;
    Aligned<T> result(num_values * lines.tetrahedron.size(), T(0));
    for (std::size_t slice = 0; slice + 1 < body.fan_start.size(); ++slice)
        for (int line = body.fan_start[slice]; line < body.fan_start[slice + 1]; ++line)
            for (std::size_t lane = 0; lane < slice_size; ++lane) {
                if (lines.tetrahedron[static_cast<std::size_t>(line) * slice_size + lane] == padding)
                    continue;
                const auto start = static_cast<std::size_t>(body.fan_start[slice]) + 3 * slice;
                const auto from = static_cast<std::size_t>(line) + 3 * slice + 2;
                std::array<int, 4> nodes{};
                std::ranges::transform(std::array{start, start + 1, from, from + 1}, nodes.begin(),
                                       [&](std::size_t at) { return lines.node[at * slice_size + lane]; });
                T *value = result.data() + num_values * static_cast<std::size_t>(line) * slice_size + lane;
                for (const double number : values_of(nodes)) {
                    *value = static_cast<T>(number);
                    value += slice_size;
                }
            }
    return result;
}

} // namespace

template <class T>
void slice_shapes(const StepParts &parts, const Eigen::VectorXd &x, const Lines &lines, SlicedBody<T> &body) {
    const bool are_around_nodes = !parts.coupled_modulus.empty();
    if (!are_around_nodes && parts.edge_modulus.empty())
        return;
    body.rest_gradient =
        values_on_lines<T>(lines, body, [&](const std::array<int, 4> &nodes) { return gradients(x, nodes); });
    if (are_around_nodes && !parts.has_means_of_tensors())
        body.rest_length =
            values_on_lines<T>(lines, body, [&](const std::array<int, 4> &nodes) { return lengths(x, nodes); });
}

template void slice_shapes(const StepParts &, const Eigen::VectorXd &, const Lines &, SlicedBody<float> &);
template void slice_shapes(const StepParts &, const Eigen::VectorXd &, const Lines &, SlicedBody<double> &);

namespace {

/// Puts the neighbours in control volumes on lines, with a place for the force on each.
template <class T>
void slice_mean_gradients(const StepParts &parts, const std::vector<int> &number_of_volume,
                          const std::vector<MeanGradient> &gradients, std::vector<std::vector<int>> &places,
                          SlicedBody<T> &body) {
    std::vector<std::vector<int>> neighbours(body.volume_row.size());
    for (std::size_t c = 0; c < gradients.size(); ++c)
        for (const auto &neighbour : gradients[c])
            neighbours[number_of_volume[c]].push_back(4 * body.row_of_node[neighbour.node]);
    body.mean_start.assign(1, 0);
    append_lists(std::move(neighbours), 4 * body.num_rows, body.mean_start, body.mean_node);
    body.mean_gradient.assign(4 * body.mean_node.size(), T(0));
    body.first_pull = padded(body.chunk_start.back() + 1); // so that vectors begin at a cache line
    const int first_in_middle = body.first_pull + static_cast<int>(body.mean_node.size());
    for (std::size_t c = 0; c < gradients.size(); ++c) {
        const int number = number_of_volume[c], lane = number % slice_size;
        int line = body.mean_start[number / slice_size];
        places[body.row_of_node[parts.centre[c]]].push_back(4 * (first_in_middle + number));
        for (const auto &neighbour : gradients[c])
            places[body.row_of_node[neighbour.node]].push_back(4 * (body.first_pull + line++ * slice_size + lane));
        put_mean_gradient(gradients[c], number, body);
    }
}

} // namespace

template <class T> void put_mean_gradient(const MeanGradient &own, int number, SlicedBody<T> &body) {
    const auto line = static_cast<std::size_t>(body.mean_start[number / slice_size]);
    T *at = body.mean_gradient.data() + 4 * line * slice_size + number % slice_size;
    for (const auto &[node, gradient, stiffness] : own)
        for (const double number_of_line : {gradient.x(), gradient.y(), gradient.z(), stiffness}) {
            *at = static_cast<T>(number_of_line);
            at += slice_size;
        }
}

template <class T> void put_volume(const StepParts &parts, int c, double rest_volume, int number, SlicedBody<T> &body) {
    const bool has_tensors = parts.has_means_of_tensors();
    if (!parts.volume_stiffness.empty()) {
        const double quarter = 0.25 * parts.volume_stiffness[c];
        body.volume_stiffness[number] = static_cast<T>(has_tensors ? quarter * rest_volume : quarter);
    }
    if (!parts.coupled_modulus.empty()) {
        double factor = 0.25;
        if (!has_tensors)
            factor = rest_volume > 0.0 ? 1.0 / (16.0 * rest_volume) : 0.0;
        else if (parts.measure == StrainMeasure::deformation_gradient)
            factor = rest_volume;
        body.coupled_modulus[number] = static_cast<T>(parts.coupled_modulus[c] * factor);
    }
    if (has_tensors)
        body.inverse_volume[number] = static_cast<T>(rest_volume > 0.0 ? 0.25 / rest_volume : 0.0);
}

template <class T>
void slice_nodal_springs(const StepParts &parts, const std::vector<core::Vector3> &positions,
                         const std::vector<int> &number_of_volume, const std::vector<MeanGradient> &gradients,
                         const Lines &lines, std::vector<std::vector<int>> &places, SlicedBody<T> &body) {
    if (parts.coupled_modulus.empty() && parts.edge_modulus.empty())
        return;
    const bool has_tensors = parts.has_means_of_tensors();
    const auto volumes = rest_volumes(parts, to_unknowns(positions));
    auto inner = parts.inner_modulus;
    if (has_tensors)
        for (std::size_t t = 0; t < inner.size(); ++t)
            inner[t] *= volumes[t];
    body.inner_modulus = on_lines<T>(inner, lines);
    if (has_tensors)
        body.volume_modulus = on_lines<T>(parts.inner_modulus, lines);
    if (!gradients.empty())
        slice_mean_gradients(parts, number_of_volume, gradients, places, body);
    else if (parts.edge_modulus.empty())
        for (auto &member : body.member)
            member *= has_tensors ? 4 : 8;
    if (!parts.coupled_modulus.empty())
        body.coupled_modulus.assign(body.volume_row.size(), T(0));
    if (has_tensors)
        body.inverse_volume.assign(body.volume_row.size(), T(0));
    const auto members = volume_members(parts);
    for (int c = 0; c < static_cast<int>(parts.centre.size()); ++c)
        put_volume(parts, c, rest_volume(parts, volumes, members.of(c)), number_of_volume[c], body);
}

template void put_mean_gradient(const MeanGradient &, int, SlicedBody<float> &);
template void put_mean_gradient(const MeanGradient &, int, SlicedBody<double> &);
template void put_volume(const StepParts &, int, double, int, SlicedBody<float> &);
template void put_volume(const StepParts &, int, double, int, SlicedBody<double> &);
template void slice_nodal_springs(const StepParts &, const std::vector<core::Vector3> &, const std::vector<int> &,
                                  const std::vector<MeanGradient> &, const Lines &, std::vector<std::vector<int>> &,
                                  SlicedBody<float> &);
template void slice_nodal_springs(const StepParts &, const std::vector<core::Vector3> &, const std::vector<int> &,
                                  const std::vector<MeanGradient> &, const Lines &, std::vector<std::vector<int>> &,
                                  SlicedBody<double> &);

} // namespace livermark::msm
