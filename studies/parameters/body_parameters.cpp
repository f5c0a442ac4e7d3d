#include "studies/parameters/body_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <numeric>

#include "msm/dynamics/highest_frequency.hpp"
#include "msm/dynamics/spectrum.hpp"
#include "msm/springs/spring_network.hpp"
#include "support/input_error.hpp"

namespace livermark::studies {

namespace {

constexpr int num_modes = 20;
/// Where the stability region of classical Runge-Kutta meets the imaginary axis.
constexpr double runge_kutta_4_limit = 2.0 * std::numbers::sqrt2;

bool is_tumour(const std::string &region) {
    return region.starts_with("tumour_");
}

core::RayleighDamping find_damping(const DampingChoice &choice, const core::Modes &modes) {
    const double first = modes.angular_frequency.front();
    if (choice.kind != DampingKind::rayleigh && !choice.frequencies.empty())
        throw support::InputError(
            "--damping-frequencies are for --damping rayleigh; by the mass or the stiffness alone "
            "the ratio is that of the first mode");
    if (choice.kind == DampingKind::mass)
        return msm::mass_proportional_damping(choice.ratio, first);
    if (choice.kind == DampingKind::stiffness)
        return msm::stiffness_proportional_damping(choice.ratio, first);
    if (choice.frequencies.empty())
        return msm::two_mode_damping(choice.ratio, first, choice.ratio, modes.angular_frequency.back());
    const double hertz = 2.0 * std::numbers::pi;
    return msm::two_mode_damping(choice.ratio, hertz * choice.frequencies.at(0), choice.ratio,
                                 hertz * choice.frequencies.at(1));
}

} // namespace

Spread spread_of(std::vector<double> values) {
    std::ranges::sort(values);
    const auto middle = values.size() / 2;
    const double sum = std::accumulate(values.begin(), values.end(), 0.0);
    return {.number = static_cast<int>(values.size()),
            .sum = sum,
            .mean = sum / static_cast<double>(values.size()),
            .median = values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]),
            .smallest = values.front(),
            .largest = values.back()};
}

double BodyParameters::frequency(int mode) const {
    return modes.angular_frequency[mode] / (2.0 * std::numbers::pi);
}

BodyParameters spring_parameters(const core::Body &body, const core::SpringNetwork &springs,
                                 const core::RayleighDamping &damping) {
    BodyParameters parameters;
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        const int region = body.mesh.region[t];
        parameters.volume += volumes[t];
        parameters.mean_young_modulus += volumes[t] * body.materials[region].young_modulus;
        if (is_tumour(body.mesh.region_names[region]))
            parameters.tumour_volume += volumes[t];
    }
    parameters.mean_young_modulus /= parameters.volume;
    parameters.damping = damping;
    auto dampers = msm::dampers(springs, damping);
    parameters.node_mass = spread_of(springs.node_mass);
    parameters.stiffness = spread_of(springs.stiffness);
    parameters.dashpot = spread_of(std::move(dampers.dashpot));
    parameters.ground_damper = spread_of(std::move(dampers.ground));
    return parameters;
}

BodyParameters body_parameters(const core::Problem &problem, const msm::SpringLaw &law, const DampingChoice &choice) {
    const auto &body = *problem.body;
    const auto springs = msm::spring_network(body, law);
    const auto conditions = msm::nodal_conditions(problem, springs.node_mass);
    auto modes = msm::lowest_modes(springs, body.mesh.points, conditions, num_modes);
    auto parameters = spring_parameters(body, springs, find_damping(choice, modes));
    parameters.modes = std::move(modes);
    parameters.largest_angular_frequency = msm::largest_angular_frequency(springs, body.mesh.points, conditions);
    parameters.critical_time_step = runge_kutta_4_limit / parameters.largest_angular_frequency;
    return parameters;
}

std::optional<core::Body> without_tumours(const core::Body &body) {
    const auto &regions = body.mesh.region_names;
    const auto parenchyma = std::ranges::find_if_not(regions, is_tumour);
    if (parenchyma == regions.end() || std::ranges::none_of(regions, is_tumour))
        return std::nullopt;
    auto healthy = body;
    for (std::size_t r = 0; r < regions.size(); ++r)
        if (is_tumour(regions[r]))
            healthy.materials[r] = body.materials[static_cast<std::size_t>(parenchyma - regions.begin())];
    return healthy;
}

} // namespace livermark::studies
