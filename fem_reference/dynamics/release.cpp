#include "fem_reference/dynamics/release.hpp"

#include <chrono>
#include <cmath>
#include <optional>

#include "core/error_norms.hpp"
#include "core/stopwatch.hpp"
#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/dynamics/mass_matrix.hpp"
#include "fem_reference/dynamics/newmark.hpp"
#include "fem_reference/dynamics/ritz_motion.hpp"

namespace livermark::fem_reference {

namespace {

using core::Clock;

double seconds_between(Clock::time_point start, Clock::time_point end) {
    return std::chrono::duration<double>(end - start).count();
}

core::History empty_history(const core::Release &plan) {
    core::History history;
    history.integrator = "newmark";
    history.time_step = plan.output_interval;
    for (int step = 0; step <= plan.num_steps; ++step)
        history.time.push_back(step * plan.output_interval);
    return history;
}

/// With the probes at the nodes of a system.
core::Release in_system(core::Release plan, const ElasticSystem &system) {
    for (auto &probe : plan.probes)
        probe.node = system.mesh_node[probe.node];
    return plan;
}

/// Newmark's method is of second order: what is left in steps an eighth as long is a part of 64.
constexpr int finer_steps = 8;

/// Rows of the probes in the vectors of a space.
Eigen::MatrixXd rows_of_probes(const core::Release &plan, const RitzSpace &space) {
    const auto num_probes = static_cast<Eigen::Index>(plan.probes.size());
    Eigen::MatrixXd rows(3 * num_probes, space.size());
    for (Eigen::Index q = 0; q < num_probes; ++q)
        rows.middleRows<3>(3 * q) =
            space.vectors().middleRows<3>(3 * static_cast<Eigen::Index>(plan.probes[static_cast<std::size_t>(q)].node));
    return rows;
}

/// The motion of the probes from u_0 in steps that are so many times shorter than records, at the records.
/// @param start  shape (3 Q) [m]
core::History probes_in_steps(const core::Release &plan, const RitzSpace &space, const Eigen::MatrixXd &rows,
                              const Eigen::VectorXd &start, int steps_per_record) {
    auto finer = plan;
    finer.output_interval /= steps_per_record;
    auto motion = motion_in(space, space.size(), finer);
    auto history = empty_history(plan);
    for (int record = 0; record <= plan.num_steps; ++record) {
        const Eigen::VectorXd u = start + rows * motion.displacement();
        for (Eigen::Index q = 0; q < u.size(); q += 3)
            history.displacement.emplace_back(u.segment<3>(q));
        for (int step = 0; step < steps_per_record; ++step)
            motion.advance();
    }
    return history;
}

/// Error of the steps in the motion of the probes: little work in a space.
core::ObservedMotionError error_of_steps(const core::Release &plan, const RitzSpace &space,
                                         const Eigen::VectorXd &start) {
    const auto rows = rows_of_probes(plan, space);
    const auto finest = probes_in_steps(plan, space, rows, start, finer_steps);
    const auto off = [&](int steps_per_record) {
        return core::compare(probes_in_steps(plan, space, rows, start, steps_per_record), finest, "finer steps")
            .relative_l2;
    };
    const double error = off(1), half = off(2);
    return {.order = std::log2(error / half), .difference = error, .relative_l2 = error};
}

/// Motion from a displacement u_0 in a space, u = u_0 + V q.
/// @param plan  in the system
void record(core::History &history, const ElasticSystem &system, const core::Release &plan, const RitzSpace &space,
            RitzMotion motion, const std::vector<double> &start, const std::vector<double> &start_force) {
    const auto num_unknowns = static_cast<Eigen::Index>(start.size());
    const Eigen::Map<const Eigen::VectorXd> u_0(start.data(), num_unknowns), force_0(start_force.data(), num_unknowns);
    const double energy_0 = 0.5 * u_0.dot(force_0);
    const Eigen::VectorXd force_on_space = space.vectors().transpose() * force_0;
    for (int step = 0; step <= plan.num_steps; ++step) {
        const Eigen::VectorXd q = motion.displacement();
        for (const auto &probe : plan.probes) {
            const auto first = 3 * static_cast<Eigen::Index>(probe.node);
            history.displacement.emplace_back(u_0.segment<3>(first) + space.vectors().middleRows<3>(first) * q);
        }
        if (plan.is_frame(step)) {
            const Eigen::VectorXd u = u_0 + space.vectors() * q;
            for (const int node : system.mesh_node)
                history.frames.emplace_back(u.segment<3>(3 * static_cast<Eigen::Index>(node)).cast<float>());
        }
        history.kinetic_energy.push_back(0.5 * motion.velocity().squaredNorm());
        history.strain_energy.push_back(energy_0 + force_on_space.dot(q) + 0.5 * q.dot(space.stiffness() * q));
        motion.advance();
    }
    Eigen::VectorXd of_probes(3 * static_cast<Eigen::Index>(plan.probes.size()));
    for (std::size_t q = 0; q < plan.probes.size(); ++q)
        of_probes.segment<3>(3 * static_cast<Eigen::Index>(q)) =
            u_0.segment<3>(3 * static_cast<Eigen::Index>(plan.probes[q].node));
    history.observed_error = error_of_steps(plan, space, of_probes);
}

/// Nothing if the motion does not lie in a space of few vectors, or if nothing holds the body.
std::optional<core::History> release_in_ritz_space(const core::Body &body, const ElasticSystem &system,
                                                   const core::LoadCase &load_case,
                                                   const std::vector<double> &displacement, ConstrainedSolver &solver) {
    const auto start = Clock::now();
    const auto plan = in_system(load_case.release.value(), system);
    const auto conditions = dof_conditions(core::without_tractions(load_case), system);
    const auto mass = consistent_mass(body, system);
    if (!solver.factorise(conditions.prescribed))
        return std::nullopt;
    const auto ready = Clock::now();

    std::vector<double> force(displacement.size()), imbalance = conditions.load;
    system.stiffness.multiply(displacement, force);
    for (std::size_t i = 0; i < force.size(); ++i)
        imbalance[i] -= force[i];
    RitzSpace space(system.stiffness, mass, solver, std::move(imbalance));
    if (!extend_until_converged(space, plan))
        return std::nullopt;
    auto history = empty_history(plan);
    record(history, system, plan, space, motion_in(space, space.size(), plan), displacement, force);
    history.setup_seconds = seconds_between(start, ready);
    history.solve_seconds = seconds_between(ready, Clock::now());
    return history;
}

} // namespace

std::optional<core::History> release_by_statics(const core::Body &body, const ElasticSystem &system,
                                                const core::LoadCase &load_case,
                                                const std::vector<double> &displacement,
                                                const std::vector<double> &force, RitzSpace::SolveStatics solve) {
    const auto start = Clock::now();
    const auto plan = in_system(load_case.release.value(), system);
    const auto mass = consistent_mass(body, system);
    auto imbalance = dof_conditions(core::without_tractions(load_case), system).load;
    for (std::size_t i = 0; i < force.size(); ++i)
        imbalance[i] -= force[i];
    const auto ready = Clock::now();
    RitzSpace space(mass, std::move(solve), std::move(imbalance));
    if (!extend_until_converged(space, plan))
        return std::nullopt;
    auto history = empty_history(plan);
    record(history, system, plan, space, motion_in(space, space.size(), plan), displacement, force);
    history.setup_seconds = seconds_between(start, ready);
    history.solve_seconds = seconds_between(ready, Clock::now());
    return history;
}

core::History release(const core::Body &body, const ElasticSystem &system, const core::LoadCase &load_case,
                      std::vector<double> displacement, ConstrainedSolver &solver) {
    const auto start = Clock::now();
    if (auto history = release_in_ritz_space(body, system, load_case, displacement, solver))
        return *std::move(history);
    const double seconds_in_vain = seconds_between(start, Clock::now());
    auto history = release_step_by_step(body, system, load_case, std::move(displacement));
    history.setup_seconds += seconds_in_vain;
    return history;
}

core::History release_step_by_step(const core::Body &body, const ElasticSystem &system, const core::LoadCase &load_case,
                                   std::vector<double> displacement) {
    const auto start = Clock::now();
    const auto &plan = load_case.release.value();
    const auto conditions = dof_conditions(core::without_tractions(load_case), system);
    const auto mass = consistent_mass(body, system);
    Newmark newmark(system.stiffness, mass, plan.damping, plan.output_interval, conditions.prescribed);
    Motion motion{std::move(displacement), std::vector<double>(conditions.load.size(), 0.0)};
    const auto ready = Clock::now();

    auto history = empty_history(plan);
    const auto record = [&](int step) {
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
    history.setup_seconds = seconds_between(start, ready);
    history.solve_seconds = seconds_between(ready, Clock::now());
    return history;
}

} // namespace livermark::fem_reference
