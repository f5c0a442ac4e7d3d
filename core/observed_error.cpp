#include "core/observed_error.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/error_norms.hpp"

namespace livermark::core {

ObservedError observed_error(const TetraMesh &mesh, std::span<const Solution> levels) {
    if (levels.size() < 3)
        throw std::invalid_argument("an order is observed on three meshes");
    const auto last = levels.last(3);
    const auto first_step = compare(mesh, last[0], last[1], "the middle mesh");
    const auto second_step = compare(mesh, last[1], last[2], "the finest mesh");
    const double factor = second_step.relative_l2 / first_step.relative_l2;
    const double believed = std::clamp(factor, smallest_believed_factor, largest_believed_factor);
    const double share = believed / (1.0 - believed);
    return {.order = -std::log2(factor),
            .difference = second_step.relative_l2,
            .relative_l2 = share * second_step.relative_l2,
            .energy = share * std::abs(second_step.energy_error),
            .reaction = std::isnan(second_step.reaction_error) ? 0.0 : share * second_step.reaction_error};
}

} // namespace livermark::core
