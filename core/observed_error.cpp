#include "core/error_norms.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

namespace livermark::core {

namespace {

/// Remainder after the last step, over that step.
double share_of(double believed_factor) {
    return believed_factor / (1.0 - believed_factor);
}

bool is_believed(double factor) {
    return factor >= smallest_believed_factor && factor <= largest_believed_factor;
}

/// Addition to the last of three numbers, over the last step: nothing where the order is not clean.
double share_to_add(double first_step, double second_step) {
    const double factor = std::abs(second_step) / std::abs(first_step);
    return is_believed(factor) ? share_of(factor) : 0.0;
}

/// out += share * (out - before)
template <class Vector> void add_share(double share, const std::vector<Vector> &before, std::vector<Vector> &out) {
    using Scalar = typename Vector::Scalar;
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] += static_cast<Scalar>(share) * (out[i] - before[i]).eval();
}

double distance(const std::vector<Vector3> &a, const std::vector<Vector3> &b) {
    double squares = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        squares += (a[i] - b[i]).squaredNorm();
    return std::sqrt(squares);
}

void require_three(std::size_t num_levels) {
    if (num_levels < 3)
        throw std::invalid_argument("an order is observed on three meshes");
}

/// The same of a factor that may not be believed.
double believed_share(double factor) {
    return share_of(std::clamp(factor, smallest_believed_factor, largest_believed_factor));
}

/// The same where no order better than the first is believed.
double share_at_rims(double factor) {
    return believed_share(std::max(factor, first_order_factor));
}

/// The same of three energies, or three sums of forces, by the sizes of their two steps.
double share_of_force(double first_step, double second_step) {
    return share_at_rims(first_step > 0.0 ? second_step / first_step : largest_believed_factor);
}

/// The size of a stiffness at the tool, which a work or a force makes; nothing where there is none.
std::optional<double> size_of(const std::optional<ToolComparison> &tool) {
    if (!tool || std::isnan(tool->stiffness()))
        return std::nullopt;
    return std::abs(tool->stiffness());
}

std::optional<double> stiffness_error(const std::optional<ToolComparison> &first_step,
                                      const std::optional<ToolComparison> &second_step) {
    const auto first = size_of(first_step), second = size_of(second_step);
    if (!first || !second)
        return std::nullopt;
    return share_of_force(*first, *second) * *second;
}

} // namespace

ObservedError observed_error(const TetraMesh &mesh, const LoadCase &load_case, std::span<const Solution> levels) {
    require_three(levels.size());
    const auto last = levels.last(3);
    const auto first_step = compare(mesh, load_case, last[0], last[1], "on the middle mesh");
    const auto second_step = compare(mesh, load_case, last[1], last[2], "on the finest mesh");
    const double factor = second_step.relative_l2 / first_step.relative_l2;
    const double share = believed_share(factor);
    const double energy_share = share_of_force(std::abs(last[1].strain_energy - last[0].strain_energy),
                                               std::abs(last[2].strain_energy - last[1].strain_energy));
    const double reaction_share =
        share_of_force(distance(last[0].reaction, last[1].reaction), distance(last[1].reaction, last[2].reaction));
    return {.order = -std::log2(factor),
            .difference = second_step.relative_l2,
            .relative_l2 = share * second_step.relative_l2,
            .energy = energy_share * std::abs(second_step.energy_error),
            .reaction = std::isnan(second_step.reaction_error) ? 0.0 : reaction_share * second_step.reaction_error,
            .stiffness = stiffness_error(first_step.tool, second_step.tool)};
}

double observed_error(std::span<const double> levels) {
    require_three(levels.size());
    const auto last = levels.last(3);
    const double first_step = std::abs(last[1] - last[0]), second_step = std::abs(last[2] - last[1]);
    return share_of_force(first_step, second_step) * second_step;
}

ObservedError observed_error_on_path(const TetraMesh &mesh, const LoadCase &load_case, std::span<const Solution> levels,
                                     std::size_t chosen) {
    require_three(levels.size());
    const std::size_t first = levels.size() - 3;
    std::size_t num_points = load_case.path.size();
    for (const auto &level : levels.subspan(first))
        num_points = std::min(num_points, level.path.size());
    if (num_points == 0 || chosen < first || chosen >= levels.size())
        throw std::invalid_argument("a level has no point of the path in common with the others");
    std::vector<Solution> there(3);
    for (std::size_t l = 0; l < there.size(); ++l) {
        const auto &point = levels[first + l].path[num_points - 1];
        for (const auto &displacement : point.displacement)
            there[l].displacement.push_back(displacement.cast<double>());
        there[l].reaction = point.reaction;
        there[l].strain_energy = point.strain_energy;
    }
    auto error = observed_error(mesh, load_case, there);
    for (std::size_t l = chosen - first; l < 2; ++l) {
        const auto step = compare(mesh, load_case, there[l], there[l + 1], "the next mesh");
        error.relative_l2 += step.relative_l2;
        error.energy += std::abs(step.energy_error);
        error.reaction += std::isnan(step.reaction_error) ? 0.0 : step.reaction_error;
        if (const auto size = size_of(step.tool); size && error.stiffness)
            *error.stiffness += *size;
    }
    error.load_fraction = load_case.path[num_points - 1];
    return error;
}

Solution extrapolated(const TetraMesh &mesh, const LoadCase &load_case, std::span<const Solution> levels) {
    auto error = observed_error(mesh, load_case, levels);
    const auto last = levels.last(3);
    auto result = last[2];
    const double factor = std::exp2(-error.order);
    const bool adds_displacement = is_believed(factor);
    bool adds_reaction = false, adds_energy = false;
    if (adds_displacement) {
        const double share = share_of(factor);
        add_share(share, last[1].displacement, result.displacement);
        for (std::size_t k = 0; k < result.path.size(); ++k)
            add_share(share, last[1].path[k].displacement, result.path[k].displacement);
        error.relative_l2 *= doubt;
    }
    if (const double share =
            share_to_add(distance(last[0].reaction, last[1].reaction), distance(last[1].reaction, last[2].reaction));
        share > 0.0) {
        adds_reaction = true;
        add_share(share, last[1].reaction, result.reaction);
        for (std::size_t k = 0; k < result.path.size(); ++k)
            add_share(share, last[1].path[k].reaction, result.path[k].reaction);
        error.reaction *= doubt;
    }
    if (const double share =
            share_to_add(last[1].strain_energy - last[0].strain_energy, last[2].strain_energy - last[1].strain_energy);
        share > 0.0) {
        adds_energy = true;
        result.strain_energy += share * (last[2].strain_energy - last[1].strain_energy);
        result.load_work += share * (last[2].load_work - last[1].load_work);
        for (std::size_t k = 0; k < result.path.size(); ++k)
            for (const auto energy : {&PathPoint::strain_energy, &PathPoint::work, &PathPoint::dissipated_energy})
                result.path[k].*energy += share * (last[2].path[k].*energy - last[1].path[k].*energy);
        error.energy *= doubt;
    }
    const auto is_better = [&](const ToolPlace &place) {
        if (place.drive != ToolDrive::traction)
            return adds_reaction;
        return std::isnan(result.load_work) ? adds_displacement : adds_energy;
    };
    if (error.stiffness && std::ranges::all_of(tool_places(mesh, load_case), is_better))
        *error.stiffness *= doubt;
    result.observed_error = error;
    return result;
}

ObservedMotionError observed_motion_error(std::span<const History> levels, double best_factor) {
    require_three(levels.size());
    const auto last = levels.last(3);
    const double first_step = compare(last[0], last[1], "on the middle mesh").relative_l2;
    const double second_step = compare(last[1], last[2], "on the finest mesh").relative_l2;
    const double factor = second_step / first_step;
    return {.order = -std::log2(factor),
            .difference = second_step,
            .relative_l2 = believed_share(std::max(factor, best_factor)) * second_step};
}

} // namespace livermark::core
