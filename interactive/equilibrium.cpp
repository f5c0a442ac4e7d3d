#include "interactive/equilibrium.hpp"

namespace livermark::interactive {

namespace {

/// From where the body is to the next fraction, in as many steps as it takes.
void advance(Equilibrium &state, double to, const Simulation &simulation, double tolerance, double press_depth) {
    const auto &energy = simulation.energy();
    const auto &scene = simulation.scene();
    const auto &external_forces = simulation.external_forces();
    const auto &targets = simulation.targets();
    constexpr double shortest = 1.0 / 256.0;
    constexpr int max_iterations = 40;
    const auto is_free = free_nodes(scene);
    const Field rest = rest_positions(scene);
    Field rest_targets(3, targets.cols());
    for (Eigen::Index c = 0; c < targets.cols(); ++c)
        rest_targets.col(c) = rest.col(scene.constrained_nodes[c]);
    const double begin = state.fraction;
    double length = to - begin;
    state.converged = false;
    while (state.fraction < to) {
        const double next = state.fraction + length > to - 1e-9 ? to : state.fraction + length;
        Field moved = state.positions;
        put_constrained(scene, rest_targets + next * (targets - rest_targets), moved);
        const bool presses = press_depth != 0.0;
        Field start = predict(energy, is_free, state.positions, moved,
                              presses ? external_forces : Field((next - state.fraction) * external_forces));
        if (presses) {
            const auto depth_of = [&](const Field &by) { return external_forces.cwiseProduct(by).sum(); };
            const double missing = next * press_depth - depth_of(state.positions - rest);
            const Field by_one_newton = start - state.positions;
            start = state.positions + missing / depth_of(by_one_newton) * by_one_newton;
        }
        auto minimum = minimise(
            energy, is_free, presses ? external_forces : Field(next * external_forces), nullptr, start,
            {.tolerance = tolerance, .max_iterations = max_iterations, .loads = presses ? Loads::press : Loads::known});
        state.iterations += minimum.iterations;
        if (minimum.converged) {
            state.fraction = next;
            state.load = presses ? minimum.press : next;
            state.positions = std::move(minimum.positions);
        } else if ((length *= 0.5) < shortest * (to - begin)) {
            break;
        }
    }
    state.converged = state.fraction == to;
    state.elastic_forces.setZero();
    energy.add_forces(state.positions, state.elastic_forces);
}

} // namespace

std::vector<Equilibrium> equilibria(const Simulation &simulation, const std::vector<double> &fractions,
                                    double tolerance, double press_depth) {
    const Field rest = rest_positions(simulation.scene());
    Equilibrium state{.positions = rest, .elastic_forces = Field::Zero(3, rest.cols())};
    std::vector<Equilibrium> result;
    for (const double fraction : fractions) {
        advance(state, fraction, simulation, tolerance, press_depth);
        result.push_back(state);
        if (!state.converged)
            break;
    }
    return result;
}

} // namespace livermark::interactive
