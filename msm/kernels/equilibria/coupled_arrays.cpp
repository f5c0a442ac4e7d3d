#include "msm/kernels/equilibria/coupled_arrays.hpp"

#include <algorithm>

#include "msm/kernels/layout/volume_members.hpp"
#include "msm/springs/tetrahedron_volume.hpp"

namespace livermark::msm {

namespace {

std::size_t in_slices(std::size_t count) {
    return (count + coupled_slice - 1) / coupled_slice * coupled_slice;
}

/// Where line k of a number stands in slices of so many lines.
std::size_t place(std::size_t number, std::size_t lines, std::size_t k) {
    const std::size_t lane = number % coupled_slice;
    return lines * (number - lane) + k * coupled_slice + lane;
}

bool are_around_nodes_alone(const StepParts &parts) {
    return !parts.coupled_modulus.empty() && parts.edges.empty() && parts.tetrahedron_stiffness.empty() &&
           !parts.has_mean_volumes && parts.is_removed.empty();
}

CoupledMeans means_of(const StepParts &parts) {
    if (parts.coupled_energy == CoupledEnergy::elongations)
        return CoupledMeans::elongations;
    return parts.has_gradient_means ? CoupledMeans::deformation_gradient : CoupledMeans::cauchy_green;
}

void add_tetrahedra(const StepParts &parts, const Eigen::VectorXd &rest, CoupledArrays &arrays) {
    const std::size_t count = parts.tetrahedra.size();
    const bool has_guard = !parts.least_volume.empty();
    arrays.num_tetrahedra = in_slices(count);
    arrays.corner.resize(4 * arrays.num_tetrahedra);
    arrays.part.resize(4 * arrays.num_tetrahedra);
    arrays.gradient.resize(9 * arrays.num_tetrahedra);
    arrays.volume.resize(arrays.num_tetrahedra, 0.0);
    arrays.inner_modulus.resize(arrays.num_tetrahedra, 0.0);
    arrays.least_relative_volume.resize(has_guard ? arrays.num_tetrahedra : 0, 0.0);
    arrays.guard_modulus.resize(has_guard ? arrays.num_tetrahedra : 0, 0.0);
    for (std::size_t number = 0; number < arrays.num_tetrahedra; ++number) {
        const std::size_t t = std::min(number, count - 1);
        const auto [volume, gradient] = volume_gradient(rest, parts.tetrahedra[t]);
        for (std::size_t a = 0; a < 4; ++a) {
            arrays.corner[place(number, 4, a)] = 4 * parts.tetrahedra[t][a];
            arrays.part[place(number, 4, a)] = static_cast<std::int32_t>(arrays.row_size) * parts.corner_volume[t][a];
        }
        for (std::size_t k = 0; k < 9; ++k)
            arrays.gradient[place(number, 9, k)] = gradient[1 + k / 3][static_cast<Eigen::Index>(k % 3)] / volume;
        if (number != t)
            continue; // fills up the slice
        arrays.volume[t] = volume;
        arrays.inner_modulus[t] = parts.inner_modulus[t];
        if (has_guard) {
            arrays.least_relative_volume[t] = parts.least_volume[t] / volume;
            arrays.guard_modulus[t] = parts.guard_stiffness[t] * volume;
        }
    }
}

void add_parts(const StepParts &parts, const Eigen::VectorXd &rest, CoupledArrays &arrays) {
    arrays.num_parts = in_slices(parts.centre.size());
    for (auto *values : {&arrays.part_volume, &arrays.part_weight, &arrays.part_modulus, &arrays.volume_modulus})
        values->resize(arrays.num_parts, 0.0);
    const auto members = volume_members(parts);
    const auto volumes = rest_volumes(parts, rest);
    for (std::size_t c = 0; c < parts.centre.size(); ++c) {
        const double volume = rest_volume(parts, volumes, members.of(static_cast<int>(c)));
        arrays.part_volume[c] = volume;
        arrays.part_weight[c] = 0.25 / volume;
        arrays.part_modulus[c] = parts.coupled_modulus[c];
        if (!parts.volume_stiffness.empty())
            arrays.volume_modulus[c] = parts.volume_stiffness[c] * volume;
    }
}

} // namespace

std::optional<CoupledArrays> coupled_arrays(const StepParts &parts, const std::vector<core::Vector3> &positions) {
    if (!are_around_nodes_alone(parts))
        return std::nullopt;
    const auto rest = to_unknowns(positions);
    CoupledArrays arrays;
    arrays.means = means_of(parts);
    arrays.num_nodes = positions.size();
    arrays.row_size = arrays.means == CoupledMeans::deformation_gradient ? 12 : 8;
    arrays.rest.resize(4 * positions.size(), 0.0);
    for (std::size_t i = 0; i < positions.size(); ++i)
        std::copy_n(positions[i].data(), 3, arrays.rest.data() + 4 * i);
    add_tetrahedra(parts, rest, arrays);
    add_parts(parts, rest, arrays);
    return arrays;
}

CoupledWorkspace::CoupledWorkspace(const CoupledArrays &body)
    : displacement(4 * body.num_nodes), direction(4 * body.num_nodes), force(4 * body.num_nodes),
      mean(body.row_size * body.num_parts), push(body.row_size * body.num_parts),
      mean_rate(body.row_size * body.num_parts), stress(7 * body.num_tetrahedra) {}

} // namespace livermark::msm
