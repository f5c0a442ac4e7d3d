#include "fem_reference/release.hpp"

#include <chrono>

#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/mass_matrix.hpp"
#include "fem_reference/newmark.hpp"

namespace livermark::fem_reference {

core::History release(const core::Body &body, const ElasticSystem &system, const core::LoadCase &load_case,
                      std::vector<double> displacement) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    const auto &plan = load_case.release.value();
    const auto conditions = dof_conditions(core::without_tractions(load_case), system);
    const auto mass = consistent_mass(body, system);
    Newmark newmark(system.stiffness, mass, plan.damping, plan.output_interval, conditions.prescribed);
    Motion motion{std::move(displacement), std::vector<double>(conditions.load.size(), 0.0)};
    const auto ready = Clock::now();

    core::History history;
    history.integrator = "newmark";
    history.time_step = plan.output_interval;
    const auto record = [&](int step) {
        history.time.push_back(step * plan.output_interval);
        for (const auto &probe : plan.probes)
            history.displacement.emplace_back(core::Vector3::Map(&motion.displacement[3 * probe.node]));
        if (plan.is_frame(step)) // the nodes of the mesh come first
            for (std::size_t i = 0; i < body.mesh.points.size(); ++i)
                history.frames.emplace_back(core::Vector3::Map(&motion.displacement[3 * i]).cast<float>());
    };
    const auto record_energy = [&](const Energy &energy) {
        history.kinetic_energy.push_back(energy.kinetic);
        history.strain_energy.push_back(energy.strain);
    };
    record(0);
    for (int step = 1; step <= plan.num_steps; ++step) {
        record_energy(newmark.advance(motion, conditions.load));
        record(step);
    }
    record_energy(newmark.energy(motion));
    history.setup_seconds = std::chrono::duration<double>(ready - start).count();
    history.solve_seconds = std::chrono::duration<double>(Clock::now() - ready).count();
    return history;
}

} // namespace livermark::fem_reference
