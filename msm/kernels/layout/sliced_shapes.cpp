#include <array>
#include <tuple>
#include <type_traits>

#include "msm/elastic_body.hpp"
#include "msm/kernels/layout/slicing.hpp"
#include "msm/springs/tetrahedron_volume.hpp"

namespace livermark::msm {

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
    const auto between = [&](int a, int b) { return (of_node(x, nodes[b]) - of_node(x, nodes[a])).norm(); };
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
    if (are_around_nodes && parts.coupled_energy == CoupledEnergy::elongations)
        body.rest_length =
            values_on_lines<T>(lines, body, [&](const std::array<int, 4> &nodes) { return lengths(x, nodes); });
}

template void slice_shapes(const StepParts &, const Eigen::VectorXd &, const Lines &, SlicedBody<float> &);
template void slice_shapes(const StepParts &, const Eigen::VectorXd &, const Lines &, SlicedBody<double> &);

} // namespace livermark::msm
