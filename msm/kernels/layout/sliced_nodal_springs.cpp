#include <utility>

#include "msm/elastic_body.hpp"
#include "msm/kernels/layout/slicing.hpp"

namespace livermark::msm {

namespace {

/// Puts the neighbours in control volumes on lines, with a place for the force on each.
template <class T>
void slice_mean_gradients(const StepParts &parts, const std::vector<int> &number_of_volume,
                          const std::vector<MeanGradient> &gradients, std::vector<std::vector<int>> &places,
                          SlicedBody<T> &body) {
    std::vector<std::vector<int>> neighbours(body.volume_row.size());
    for (std::size_t c = 0; c < gradients.size(); ++c)
        for (const auto &of_neighbour : gradients[c])
            neighbours[number_of_volume[c]].push_back(4 * body.row_of_node[of_neighbour.node]);
    body.mean_start.assign(1, 0);
    append_lists(std::move(neighbours), 4 * body.num_rows, body.mean_start, body.mean_node);
    body.mean_gradient.assign(4 * body.mean_node.size(), T(0));
    body.first_pull = padded(body.chunk_start.back() + 1); // so that vectors begin at a cache line
    const int first_in_middle = body.first_pull + static_cast<int>(body.mean_node.size());
    for (std::size_t c = 0; c < gradients.size(); ++c) {
        const int number = number_of_volume[c], lane = number % slice_size;
        int line = body.mean_start[number / slice_size];
        places[body.row_of_node[parts.centre[c]]].push_back(4 * (first_in_middle + number));
        for (const auto &of_neighbour : gradients[c])
            places[body.row_of_node[of_neighbour.node]].push_back(4 * (body.first_pull + line++ * slice_size + lane));
        put_mean_gradient(gradients[c], number, body);
    }
}

} // namespace

template <class T> void put_mean_gradient(const MeanGradient &of_volume, int number, SlicedBody<T> &body) {
    const auto line = static_cast<std::size_t>(body.mean_start[number / slice_size]);
    T *at = body.mean_gradient.data() + 4 * line * slice_size + number % slice_size;
    for (const auto &[node, gradient, stiffness] : of_volume)
        for (const double number_of_line : {gradient.x(), gradient.y(), gradient.z(), stiffness}) {
            *at = static_cast<T>(number_of_line);
            at += slice_size;
        }
}

template <class T> void put_volume(const StepParts &parts, int c, double rest_volume, int number, SlicedBody<T> &body) {
    const bool has_springs = !parts.coupled_modulus.empty() || !parts.edge_modulus.empty();
    const bool is_neo_hookean = has_springs && parts.coupled_energy == CoupledEnergy::neo_hookean;
    if (!parts.volume_stiffness.empty()) {
        const double quarter = 0.25 * parts.volume_stiffness[c];
        body.volume_stiffness[number] = static_cast<T>(is_neo_hookean ? quarter * rest_volume : quarter);
    }
    if (!parts.coupled_modulus.empty()) {
        double factor = 0.25;
        if (!is_neo_hookean)
            factor = rest_volume > 0.0 ? 1.0 / (16.0 * rest_volume) : 0.0;
        else if (parts.has_gradient_means)
            factor = rest_volume;
        body.coupled_modulus[number] = static_cast<T>(parts.coupled_modulus[c] * factor);
    }
    if (is_neo_hookean)
        body.inverse_volume[number] = static_cast<T>(rest_volume > 0.0 ? 0.25 / rest_volume : 0.0);
}

template <class T>
void slice_nodal_springs(const StepParts &parts, const std::vector<core::Vector3> &positions,
                         const std::vector<int> &number_of_volume, const std::vector<MeanGradient> &gradients,
                         const Lines &lines, std::vector<std::vector<int>> &places, SlicedBody<T> &body) {
    if (parts.coupled_modulus.empty() && parts.edge_modulus.empty())
        return;
    const bool is_neo_hookean = parts.coupled_energy == CoupledEnergy::neo_hookean;
    const auto volumes = rest_volumes(parts, to_unknowns(positions));
    auto inner = parts.inner_modulus;
    if (is_neo_hookean)
        for (std::size_t t = 0; t < inner.size(); ++t)
            inner[t] *= volumes[t];
    body.inner_modulus = on_lines<T>(inner, lines);
    if (is_neo_hookean)
        body.volume_modulus = on_lines<T>(parts.inner_modulus, lines);
    if (!gradients.empty())
        slice_mean_gradients(parts, number_of_volume, gradients, places, body);
    else if (parts.edge_modulus.empty())
        for (auto &member : body.member)
            member *= is_neo_hookean ? 4 : 8;
    if (!parts.coupled_modulus.empty())
        body.coupled_modulus.assign(body.volume_row.size(), T(0));
    if (is_neo_hookean)
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
