#pragma once

#include <cmath>

#include "interactive/equilibrium.hpp"

/// States that steps of a simulation are compared with.
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

/// The static solution under the whole load, along a path of four parts.
inline interactive::Equilibrium equilibrium(const interactive::Simulation &simulation) {
    return interactive::equilibria(simulation, {0.25, 0.5, 0.75, 1.0}).back();
}

/// Rest of a simulation, found by its own steps.
struct Settled {
    bool converged = false;
    int steps = 0;
    double last_move = 0.0; ///< longest move of a node in the last step, over its longest displacement
};

/// Lets a simulation come to rest by its own steps, with all velocities set to zero after each: where it stays is its
/// own static solution, with as many iterations as it gets.
/// @param tolerance  of the last move
inline Settled settle(interactive::Simulation &simulation, double time_step, int iterations, double tolerance,
                      int max_steps) {
    using interactive::Field;
    const Field rest = interactive::rest_positions(simulation.scene());
    const Field still = Field::Zero(3, rest.cols());
    Settled settled;
    simulation.set_state(simulation.positions(), still);
    while (!settled.converged && settled.steps < max_steps) {
        const Field before = simulation.positions();
        simulation.step(time_step, iterations);
        simulation.set_state(simulation.positions(), still);
        ++settled.steps;
        const double move = (simulation.positions() - before).colwise().norm().maxCoeff();
        const double longest = (simulation.positions() - rest).colwise().norm().maxCoeff();
        settled.last_move = move == 0.0 ? 0.0 : move / longest;
        settled.converged = settled.last_move <= tolerance;
        if (!std::isfinite(settled.last_move))
            break;
    }
    return settled;
}

} // namespace livermark::tests
