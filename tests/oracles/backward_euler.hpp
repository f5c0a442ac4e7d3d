#pragma once

#include "interactive/minimiser.hpp"

namespace livermark::tests {

/// Backward Euler by Newton's method: the positions at the end of a step from where a simulation is, to its targets.
inline interactive::Minimum backward_euler(const interactive::Simulation &simulation, double time_step) {
    using interactive::Field;
    const auto terms = interactive::inertia(simulation, time_step);
    const auto is_free = interactive::free_nodes(simulation.scene());
    Field start = simulation.positions();
    for (Eigen::Index i = 0; i < start.cols(); ++i)
        if (!is_free[i])
            start.col(i) = terms.predicted.col(i);
    // The external forces are in where the nodes would go.
    const Field none = Field::Zero(3, start.cols());
    return interactive::minimise(simulation.energy(), is_free, none, &terms, start);
}

} // namespace livermark::tests
