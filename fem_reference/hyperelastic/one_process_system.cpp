#include "fem_reference/hyperelastic/one_process_system.hpp"

namespace livermark::hyperelastic {

OneProcessSystem::OneProcessSystem(const Elements &elements, const fem_reference::DofConditions &conditions,
                                   std::span<const double> pressure, TouchingBall *ball)
    : PathSystem(elements, conditions, pressure, ball), solver_(elements, free_of(conditions.prescribed)),
      counted_displacements_(elements.num_displacements(), true), counted_pressures_(elements.num_pressures(), true) {}

} // namespace livermark::hyperelastic
