#include "interactive/equilibrium.hpp"

#include <algorithm>
#include <cmath>

namespace livermark::interactive {

Equilibrium equilibrium(const Energy &energy, const Scene &scene, const Field &external_forces, const Field &targets,
                        double tolerance, int load_steps) {
    constexpr double shortest = 1.0 / 512.0;
    const auto is_free = free_nodes(scene);
    const Field rest = rest_positions(scene);
    Equilibrium found{rest, Field::Zero(3, rest.cols())};
    double length = 1.0 / load_steps;
    while (found.fraction < 1.0) {
        const double next = std::min(1.0, found.fraction + length);
        Field moved = found.positions;
        for (Eigen::Index c = 0; c < targets.cols(); ++c) {
            const int node = scene.constrained_nodes[c];
            moved.col(node) = rest.col(node) + next * (targets.col(c) - rest.col(node));
        }
        const Field start = predict(energy, is_free, found.positions, moved, (next - found.fraction) * external_forces);
        auto minimum = minimise(energy, is_free, next * external_forces, nullptr, start,
                                {.tolerance = tolerance, .max_iterations = 60});
        found.iterations += minimum.iterations;
        if (minimum.converged) {
            ++found.load_steps;
            found.fraction = next;
            found.positions = std::move(minimum.positions);
        } else if ((length *= 0.5) < shortest) {
            break;
        }
    }
    found.converged = found.fraction == 1.0;
    energy.add_forces(found.positions, found.elastic_forces);
    return found;
}

Equilibrium equilibrium(const Simulation &simulation, double tolerance, int load_steps) {
    return equilibrium(simulation.energy(), simulation.scene(), simulation.external_forces(), simulation.targets(),
                       tolerance, load_steps);
}

Settled settle(Simulation &simulation, double time_step, int iterations, double tolerance, int max_steps) {
    const Field rest = rest_positions(simulation.scene());
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

} // namespace livermark::interactive
