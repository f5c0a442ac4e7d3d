#include "fem_reference/dynamics/release.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/error_norms.hpp"
#include "core/stopwatch.hpp"
#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"

namespace livermark::fem_reference {

Newmark::Newmark(const SymmetricBlocks<double> &stiffness, const SymmetricMatrix &mass,
                 const core::RayleighDamping &damping, double time_step, std::span<const double> prescribed)
    : stiffness_(&stiffness), mass_(&mass), time_step_(time_step),
      solver_(
          combine(damping.beta + 0.5 * time_step, compressed_rows(stiffness), damping.alpha + 2.0 / time_step, mass)),
      force_(3 * static_cast<std::size_t>(mass.num_rows())), momentum_(force_.size()), mean_velocity_(force_.size()) {
    solver_.factorise(prescribed); // the mass makes it positive definite, whatever is constrained
}

/// force = K u, momentum = M v
Energy Newmark::energy(const Motion &motion) {
    stiffness_->multiply(motion.displacement, force_);
    multiply_mass(*mass_, motion.velocity, momentum_);
    return {.kinetic = 0.5 * dot(motion.velocity, momentum_), .strain = 0.5 * dot(motion.displacement, force_)};
}

Energy Newmark::advance(Motion &motion, std::span<const double> load) {
    const auto before = energy(motion);
    for (std::size_t i = 0; i < force_.size(); ++i)
        force_[i] = 2.0 / time_step_ * momentum_[i] + load[i] - force_[i];
    solver_.solve_constrained(force_, mean_velocity_);
    for (std::size_t i = 0; i < force_.size(); ++i) {
        motion.displacement[i] += time_step_ * mean_velocity_[i];
        motion.velocity[i] = 2.0 * mean_velocity_[i] - motion.velocity[i];
    }
    return before;
}

namespace {

/// Remainder of a vector when the space is taken out of it, below which it is but rounding of what was taken out.
constexpr double rounding = 1e-12;
/// More than a motion takes as a rule: growing would go through the memory again, and what is not used costs nothing.
constexpr Eigen::Index columns_at_once = 128;
/// Nearly all of the motion is in the first vectors, so they are found in double precision; the others may be a little
/// off the way, as what they leave out is looked at.
constexpr Eigen::Index num_exact = 5;

} // namespace

RitzSpace::RitzSpace(const SymmetricBlocks<double> &stiffness, const SymmetricMatrix &mass, ConstrainedSolver &solver,
                     std::vector<double> force)
    : stiffness_(&stiffness), mass_(mass), solver_(&solver), force_(std::move(force)), next_load_(force_),
      vector_(force_.size()), product_(force_.size()), vectors_(force_.size(), 0) {}

RitzSpace::RitzSpace(const SymmetricMatrix &mass, SolveStatics solve, std::vector<double> force)
    : mass_(mass), solve_statics_(std::move(solve)), force_(std::move(force)), next_load_(force_),
      vector_(force_.size()), product_(force_.size()), force_of_vector_(force_.size()), vectors_(force_.size(), 0),
      forces_(force_.size(), 0) {}

void RitzSpace::solve() {
    if (solve_statics_)
        solve_statics_(next_load_, vector_, force_of_vector_);
    else if (size() < num_exact)
        solver_->solve_constrained(next_load_, vector_);
    else
        solver_->solve_single_precision(next_load_, vector_);
}

/// Takes the space out of what was solved, and makes its size 1; its product with M is beside it.
/// @return false if nothing is left
bool RitzSpace::make_orthogonal() {
    const auto num_unknowns = static_cast<Eigen::Index>(force_.size());
    Eigen::Map<Eigen::VectorXd> vector(vector_.data(), num_unknowns), product(product_.data(), num_unknowns),
        force(force_of_vector_.data(), std::ssize(force_of_vector_));
    multiply_mass(mass_, vector_, product_);
    const double size_before = std::sqrt(vector.dot(product));
    // Twice is enough (W. Kahan, in B. N. Parlett 1980, The symmetric eigenvalue problem, 6-9); once is not, because
    // the rounding of one vector grows in those after it.
    for (int pass = 0; pass < 2; ++pass) {
        const Eigen::VectorXd component = vectors().transpose() * product;
        vector.noalias() -= vectors() * component;
        if (solve_statics_)
            force.noalias() -= forces_.leftCols(size()) * component;
        multiply_mass(mass_, vector_, product_);
    }
    const double left = std::sqrt(vector.dot(product));
    if (!(left > rounding * size_before))
        return false;
    vector /= left;
    product /= left;
    force /= left;
    return true;
}

bool RitzSpace::extend() {
    const auto num_unknowns = static_cast<Eigen::Index>(force_.size());
    solve();
    if (!make_orthogonal())
        return false;
    next_load_ = product_;

    const auto last = size();
    if (last == vectors_.cols()) {
        vectors_.conservativeResize(Eigen::NoChange, last + columns_at_once);
        if (solve_statics_)
            forces_.conservativeResize(Eigen::NoChange, last + columns_at_once);
    }
    vectors_.col(last) = Eigen::VectorXd::Map(vector_.data(), num_unknowns);
    force_on_space_.conservativeResize(last + 1);
    force_on_space_[last] = dot(vector_, force_);
    if (solve_statics_) {
        forces_.col(last) = Eigen::VectorXd::Map(force_of_vector_.data(), num_unknowns);
        product_ = force_of_vector_;
    } else {
        stiffness_->multiply(vector_, product_);
    }
    stiffness_of_space_.conservativeResize(last + 1, last + 1);
    stiffness_of_space_.col(last) =
        vectors_.leftCols(last + 1).transpose() * Eigen::VectorXd::Map(product_.data(), num_unknowns);
    stiffness_of_space_.row(last) = stiffness_of_space_.col(last).transpose();
    return true;
}

namespace {

constexpr double motion_tolerance = 5e-5;
constexpr int vectors_per_check = 5;
constexpr int vectors_left_out = 10; ///< of the motion that a check compares with
/// Size from which what the vectors change goes down at the pace that it keeps.
constexpr int fewest_to_extrapolate = 40;
/// A probe that moves less than this part of the one that moves most counts as if it moved that much.
constexpr double least_part = 1e-3;

/// Rows of the probes in the vectors of a space.
Eigen::MatrixXd rows_of_probes(const core::Release &plan, const RitzSpace &space) {
    const auto num_probes = static_cast<Eigen::Index>(plan.probes.size());
    Eigen::MatrixXd rows(3 * num_probes, space.size());
    for (Eigen::Index q = 0; q < num_probes; ++q)
        rows.middleRows<3>(3 * q) =
            space.vectors().middleRows<3>(3 * static_cast<Eigen::Index>(plan.probes[static_cast<std::size_t>(q)].node));
    return rows;
}

/// Changes by the last vectors in the motion of the whole body and of each probe, the largest of these parts.
double largest_change(const RitzSpace &space, const core::Release &release) {
    const auto num_probes = static_cast<Eigen::Index>(release.probes.size());
    const auto rows = rows_of_probes(release, space);
    const Eigen::Index num_before = space.size() - vectors_left_out;
    auto motion = motion_in(space, space.size(), release);
    auto motion_before = motion_in(space, num_before, release);
    double moved = 0.0, changed = 0.0; // squares, summed over time; V is orthonormal
    Eigen::ArrayXd probe_moved = Eigen::ArrayXd::Zero(num_probes), probe_changed = probe_moved;
    for (int step = 0; step < release.num_steps; ++step) {
        motion.advance();
        motion_before.advance();
        const Eigen::VectorXd z = motion.displacement();
        Eigen::VectorXd change = z;
        change.head(num_before) -= motion_before.displacement();
        moved += z.squaredNorm();
        changed += change.squaredNorm();
        const Eigen::VectorXd probes = rows * z, change_of_probes = rows * change;
        probe_moved += probes.reshaped(3, num_probes).colwise().squaredNorm().transpose().array();
        probe_changed += change_of_probes.reshaped(3, num_probes).colwise().squaredNorm().transpose().array();
    }
    double largest = changed / moved;
    const double least = least_part * least_part * (num_probes > 0 ? probe_moved.maxCoeff() : 0.0);
    for (Eigen::Index q = 0; q < num_probes; ++q)
        if (probe_changed[q] > 0.0)
            largest = std::max(largest, probe_changed[q] / std::max(probe_moved[q], least));
    return std::sqrt(largest);
}

} // namespace

RitzMotion::RitzMotion(const Eigen::MatrixXd &stiffness, const Eigen::VectorXd &force,
                       const core::RayleighDamping &damping, double time_step)
    : time_step_(time_step), displacement_(Eigen::ArrayXd::Zero(force.size())), velocity_(displacement_) {
    if (force.size() == 0)
        return;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(stiffness);
    modes_ = solver.eigenvectors();
    square_ = solver.eigenvalues();
    force_ = modes_.transpose() * force;
    effective_ = 2.0 / time_step + damping.alpha + (damping.beta + 0.5 * time_step) * square_;
}

void RitzMotion::advance() {
    const Eigen::ArrayXd mean_velocity = (2.0 / time_step_ * velocity_ + force_ - square_ * displacement_) / effective_;
    displacement_ += time_step_ * mean_velocity;
    velocity_ = 2.0 * mean_velocity - velocity_;
}

RitzMotion motion_in(const RitzSpace &space, Eigen::Index num_vectors, const core::Release &release) {
    return {space.stiffness().topLeftCorner(num_vectors, num_vectors), space.force().head(num_vectors), release.damping,
            release.output_interval};
}

bool extend_until_converged(RitzSpace &space, const core::Release &release) {
    const int most = release.num_steps / 2; // a vector costs as much as one or two steps
    std::vector<double> changes;
    for (int size = vectors_per_check; size <= most; size += vectors_per_check) {
        while (space.size() < size)
            if (!space.extend())
                return true;
        if (size <= vectors_left_out)
            continue;
        changes.push_back(largest_change(space, release));
        if (changes.back() < motion_tolerance)
            return true;
        if (size >= fewest_to_extrapolate) {
            const double before = changes.end()[-1 - vectors_left_out / vectors_per_check];
            const double decades_per_vector = std::log10(before / changes.back()) / vectors_left_out;
            if (!(decades_per_vector * (most - size) > std::log10(changes.back() / motion_tolerance)))
                return false;
        }
    }
    return false;
}

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

/// The same plan with the probes at the nodes of a system.
core::Release in_system(core::Release plan, const ElasticSystem &system) {
    for (auto &probe : plan.probes)
        probe.node = system.mesh_node[probe.node];
    return plan;
}

/// Newmark's method is of second order: what is left in steps an eighth as long is a part of 64.
constexpr int finer_steps = 8;

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
    Eigen::VectorXd at_probes(3 * static_cast<Eigen::Index>(plan.probes.size()));
    for (std::size_t q = 0; q < plan.probes.size(); ++q)
        at_probes.segment<3>(3 * static_cast<Eigen::Index>(q)) =
            u_0.segment<3>(3 * static_cast<Eigen::Index>(plan.probes[q].node));
    history.observed_error = error_of_steps(plan, space, at_probes);
}

/// Motion from a displacement in a space that is extended until it holds it.
/// @param force       shape (3 n) [N] of the displacement
/// @param start, ready  of the set-up
/// @return nothing if the motion does not lie in a space of few vectors
std::optional<core::History> motion_from(const std::vector<double> &displacement, const std::vector<double> &force,
                                         const ElasticSystem &system, const core::Release &plan, RitzSpace &space,
                                         Clock::time_point start, Clock::time_point ready) {
    if (!extend_until_converged(space, plan))
        return std::nullopt;
    auto history = empty_history(plan);
    record(history, system, plan, space, motion_in(space, space.size(), plan), displacement, force);
    history.setup_seconds = seconds_between(start, ready);
    history.solve_seconds = seconds_between(ready, Clock::now());
    return history;
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
    return motion_from(displacement, force, system, plan, space, start, ready);
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
    return motion_from(displacement, force, system, plan, space, start, ready);
}

core::History release(const core::Body &body, const ElasticSystem &system, const core::LoadCase &load_case,
                      std::vector<double> displacement, ConstrainedSolver &solver) {
    const auto start = Clock::now();
    if (auto history = release_in_ritz_space(body, system, load_case, displacement, solver))
        return *std::move(history);
    const double seconds_in_vain = seconds_between(start, Clock::now());
    const auto in_steps_of = [&](const core::LoadCase &any) {
        return release_step_by_step(body, system, any, displacement);
    };
    auto history = in_steps_of(load_case);
    history.setup_seconds += seconds_in_vain;
    history.observed_error = error_of_longer_steps(load_case, history, in_steps_of);
    return history;
}

namespace {

/// Probes at every so many records, at the times of the longest steps.
core::History at_common_records(const core::History &motion, int factor, const std::vector<double> &times) {
    const auto num_probes = motion.displacement.size() / motion.time.size();
    core::History thinned;
    thinned.time = times;
    for (std::size_t record = 0; record < times.size(); ++record) {
        const auto first = motion.displacement.begin() +
                           static_cast<std::ptrdiff_t>(record * static_cast<std::size_t>(factor) * num_probes);
        thinned.displacement.insert(thinned.displacement.end(), first, first + static_cast<std::ptrdiff_t>(num_probes));
    }
    return thinned;
}

} // namespace

std::optional<core::ObservedMotionError>
error_of_longer_steps(const core::LoadCase &load_case, const core::History &motion,
                      const std::function<core::History(const core::LoadCase &)> &release) {
    constexpr int longest = 4; // steps of the motion in one
    const auto &plan = load_case.release.value();
    const int num_longest = plan.num_steps / longest;
    if (num_longest < 1)
        return std::nullopt;
    const auto in_steps = [&](int factor) {
        auto longer = load_case;
        longer.release->num_steps = num_longest * longest / factor;
        longer.release->output_interval *= factor;
        return release(longer);
    };
    const auto coarse = in_steps(longest), middle = in_steps(longest / 2);
    const auto &times = coarse.time;
    const std::array levels{coarse, at_common_records(middle, longest / 2, times),
                            at_common_records(motion, longest, times)};
    const auto error = core::observed_motion_error(levels, core::smallest_believed_factor);
    if (!(error.order > -std::numeric_limits<double>::infinity())) // the differences have no factor
        return std::nullopt;
    return error;
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
