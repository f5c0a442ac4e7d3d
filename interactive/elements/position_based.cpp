#include "interactive/elements/position_based.hpp"

#include <utility>

#include "interactive/elements/energies.hpp"
#include "interactive/kernels/method_steps.hpp"

namespace livermark::interactive {

PositionBased::PositionBased(Scene given) : SimulationInRows(std::move(given)), rows_(scene()) {}

bool PositionBased::touch(const std::shared_ptr<core::BallContact> &ball) {
    rows_.after_iteration = ball ? [this] { project_ball(); } : std::function<void()>();
    return SimulationInRows::touch(ball);
}

void PositionBased::project_ball() {
    const auto start = [&](int n) { return rest_.col(n) + in_row(rows_.before, n).cast<double>(); };
    const auto position = [&](int n) { return row_position(n); };
    const double per_mass = time_step_ * time_step_ / (1.0 + scene().mass_damping * time_step_);
    const auto yields = [&](int n) { return is_free()[n] ? per_mass / scene().node_mass[n] : 0.0; };
    const auto give = [&](int n, const core::Vector3 &force) { position(n) += yields(n) * force; };
    if (!has_touched_)
        ball_->begin_step(give);
    has_touched_ = true;
    ball_->sweep(
        ball_->part(0, 1), start, position,
        [&](int n) { return Eigen::Matrix3d(yields(n) * Eigen::Matrix3d::Identity()); }, give);
}

void PositionBased::step(double time_step, int iterations) {
    time_step_ = time_step;
    has_touched_ = false;
    rows_.aim_constrained(scene(), rest_, positions(), targets(), time_step);
    kernels::take_position_step(rows_, time_step, scene().mass_damping, iterations);
    take_state_from_rows();
    if (ball_)
        ball_->end_step(time_step);
    last_time_step_ = time_step;
}

void PositionBased::set_state(const Field &positions, const Field &velocities) {
    SimulationInRows::set_state(positions, velocities);
    last_time_step_.reset();
}

void PositionBased::kick(const Field &velocity, double time_step) {
    const auto last_time_step = last_time_step_; // multipliers are still those of the step
    Simulation::kick(velocity, time_step);
    last_time_step_ = last_time_step;
}

Field PositionBased::elastic_forces() const {
    if (!last_time_step_)
        return Simulation::elastic_forces();
    Field forces = Field::Zero(3, positions().cols());
    add_constraint_forces(positions(), *last_time_step_, rows_.sets, forces);
    return forces;
}

} // namespace livermark::interactive
