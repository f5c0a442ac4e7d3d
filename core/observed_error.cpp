#include "core/observed_error.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/error_norms.hpp"

namespace livermark::core {

namespace {

void require_three(std::size_t num_levels) {
    if (num_levels < 3)
        throw std::invalid_argument("an order is observed on three meshes");
}

/// d r / (1 - r) over d.
double share_of_last_difference(double factor) {
    const double believed = std::clamp(factor, smallest_believed_factor, largest_believed_factor);
    return believed / (1.0 - believed);
}

} // namespace

ObservedError observed_error(const TetraMesh &mesh, std::span<const Solution> levels) {
    require_three(levels.size());
    const auto last = levels.last(3);
    const auto first_step = compare(mesh, last[0], last[1], "the middle mesh");
    const auto second_step = compare(mesh, last[1], last[2], "the finest mesh");
    const double factor = second_step.relative_l2 / first_step.relative_l2;
    const double share = share_of_last_difference(factor);
    return {.order = -std::log2(factor),
            .difference = second_step.relative_l2,
            .relative_l2 = share * second_step.relative_l2,
            .energy = share * std::abs(second_step.energy_error),
            .reaction = std::isnan(second_step.reaction_error) ? 0.0 : share * second_step.reaction_error};
}

ObservedMotionError observed_motion_error(std::span<const History> levels) {
    require_three(levels.size());
    const auto last = levels.last(3);
    const double first_step = compare(last[0], last[1], "the middle mesh").relative_l2;
    const double second_step = compare(last[1], last[2], "the finest mesh").relative_l2;
    const double factor = second_step / first_step;
    constexpr double of_first_order = 0.5;
    return {.order = -std::log2(factor),
            .difference = second_step,
            .relative_l2 = share_of_last_difference(std::max(factor, of_first_order)) * second_step};
}

} // namespace livermark::core
