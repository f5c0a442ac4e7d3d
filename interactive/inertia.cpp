#include "interactive/inertia.hpp"

namespace livermark::interactive {

Inertia inertia(const Simulation &simulation, double time_step) {
    const auto &scene = simulation.scene();
    const double damping = 1.0 + scene.mass_damping * time_step;
    const auto &x = simulation.positions();
    Inertia inertia{std::vector<double>(scene.node_mass.size()), Field(3, x.cols())};
    for (Eigen::Index i = 0; i < x.cols(); ++i) {
        const double mass = scene.node_mass[i];
        inertia.stiffness[i] = mass * damping / (time_step * time_step);
        inertia.predicted.col(i) = x.col(i) + (time_step * simulation.velocities().col(i) +
                                               time_step * time_step / mass * simulation.external_forces().col(i)) /
                                                  damping;
    }
    put_constrained(scene, simulation.targets(), inertia.predicted);
    return inertia;
}

} // namespace livermark::interactive
