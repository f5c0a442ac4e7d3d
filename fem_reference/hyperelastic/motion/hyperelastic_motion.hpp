#pragma once

#include <vector>

#include "core/solution.hpp"
#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/motion/energy_momentum.hpp"

namespace livermark::hyperelastic {

/// What release() finds.
struct ReleasedBody {
    core::History history;
    EnergyMomentum::Work work;
};

/// Lets all tractions of a load case go at t = 0, also pressures that follow the surface, and follows the body from
/// rest with EnergyMomentum, a step per output interval.
/// @param elements      in displacements alone
/// @param rule          that they were made with
/// @param load_case     of the body's mesh, with its release
/// @param displacement  where it starts, shape (3 n) [m]
/// @return of a motion that finds no next step, the records from then on are NaN, and diverged_at says when
/// @throws std::invalid_argument for mixed elements
/// @throws std::runtime_error if the memory does not hold a factor
ReleasedBody release(const Elements &elements, TetrahedronRule rule, const core::LoadCase &load_case,
                     std::vector<double> displacement);

} // namespace livermark::hyperelastic
