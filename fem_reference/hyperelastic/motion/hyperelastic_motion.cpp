#include "fem_reference/hyperelastic/motion/hyperelastic_motion.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "core/stopwatch.hpp"
#include "fem_reference/dof_conditions.hpp"

namespace livermark::hyperelastic {

namespace {

/// Size of what holds a body in balance at the start, reactions and loads: what a motion is measured by.
double force_at(const Elements &elements, const std::vector<double> &displacement) {
    double square = 0.0;
    for (const double force : elements.internal_forces({displacement, {}}).force)
        square += force * force;
    return std::sqrt(square);
}

} // namespace

ReleasedBody release(const Elements &elements, TetrahedronRule rule, const core::LoadCase &load_case,
                     std::vector<double> displacement) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const auto start = core::Clock::now();
    const auto &plan = load_case.release.value();
    const auto conditions = fem_reference::dof_conditions(core::without_tractions(load_case), elements.system());
    std::vector<bool> is_free;
    for (const double value : conditions.prescribed)
        is_free.push_back(std::isnan(value));
    EnergyMomentum steps(elements, rule, is_free, plan.damping, force_at(elements, displacement));
    fem_reference::Motion motion{std::move(displacement), std::vector<double>(is_free.size(), 0.0)};

    core::History history;
    history.integrator = "energy_momentum";
    history.time_step = plan.output_interval;
    history.setup_seconds = core::seconds_since(start);
    const auto motion_start = core::Clock::now();
    const auto &mesh_node = elements.system().mesh_node;
    const auto record = [&](int step, bool is_lost) {
        const auto displacement_of = [&](int node) -> core::Vector3 {
            if (is_lost)
                return core::Vector3::Constant(nan);
            return core::Vector3::Map(&motion.displacement[3 * mesh_node[node]]);
        };
        history.time.push_back(step * plan.output_interval);
        for (const auto &probe : plan.probes)
            history.displacement.push_back(displacement_of(probe.node));
        if (plan.is_frame(step))
            for (std::size_t node = 0; node < mesh_node.size(); ++node)
                history.frames.emplace_back(displacement_of(static_cast<int>(node)).cast<float>());
        const auto energy = is_lost ? fem_reference::Energy{nan, nan} : steps.energy(motion);
        history.kinetic_energy.push_back(energy.kinetic);
        history.strain_energy.push_back(energy.strain);
    };
    record(0, false);
    for (int step = 1; step <= plan.num_steps; ++step) {
        const bool was_lost = !std::isnan(history.diverged_at);
        if (!was_lost && !steps.advance(motion, conditions.load, plan.output_interval))
            history.diverged_at = step * plan.output_interval;
        record(step, !std::isnan(history.diverged_at));
    }
    history.solve_seconds = core::seconds_since(motion_start);
    return {std::move(history), steps.work()};
}

} // namespace livermark::hyperelastic
