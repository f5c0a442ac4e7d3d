#include "interactive/elements/position_based.hpp"

#include <utility>

#include "interactive/elements/tetrahedra.hpp"
#include "interactive/kernels/position_rows.hpp"

namespace livermark::interactive {

PositionBased::PositionBased(Scene given) : Simulation(std::move(given)), rest_(positions()), rows_(scene()) {}

bool PositionBased::touch(const std::shared_ptr<core::BallContact> &ball) {
    ball_ = ball;
    if (ball_)
        rows_.after_iteration = [this] {
            project_ball([&](int n) { return rest_.col(n) + in_row(rows_.before, n).cast<double>(); },
                         [&](int n) { return FineRow(rest_.col(n), in_row(rows_.displacement, n)); });
        };
    else
        rows_.after_iteration = nullptr;
    return true;
}

template <class Start, class Position> void PositionBased::project_ball(const Start &start, const Position &position) {
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
    auto &x = mutable_positions();
    auto &v = mutable_velocities();
    // Constrained nodes begin where they were told to be before, without what single precision has lost on the way.
    const auto &nodes = scene().constrained_nodes;
    for (std::size_t c = 0; c < nodes.size(); ++c) {
        in_row(rows_.displacement, nodes[c]) = (x.col(nodes[c]) - rest_.col(nodes[c])).cast<float>();
        in_row(rows_.velocity, nodes[c]) =
            ((targets().col(static_cast<Eigen::Index>(c)) - x.col(nodes[c])) / time_step).cast<float>();
    }
    kernels::take_position_step(rows_, time_step, scene().mass_damping, iterations);
    for (Eigen::Index i = 0; i < x.cols(); ++i) {
        x.col(i) = rest_.col(i) + in_row(rows_.displacement, static_cast<int>(i)).cast<double>();
        v.col(i) = in_row(rows_.velocity, static_cast<int>(i)).cast<double>();
    }
    move_to_targets(); // to the last bit
    if (ball_)
        ball_->end_step(time_step);
    last_time_step_ = time_step;
}

void PositionBased::set_state(const Field &positions, const Field &velocities) {
    Simulation::set_state(positions, velocities);
    last_time_step_.reset();
    for (Eigen::Index i = 0; i < positions.cols(); ++i) {
        in_row(rows_.displacement, static_cast<int>(i)) = (positions.col(i) - rest_.col(i)).cast<float>();
        in_row(rows_.velocity, static_cast<int>(i)) = velocities.col(i).cast<float>();
    }
}

void PositionBased::kick(const Field &velocity, double time_step) {
    const auto last_time_step = last_time_step_; // multipliers are still those of the step
    Simulation::kick(velocity, time_step);
    last_time_step_ = last_time_step;
}

void PositionBased::set_external_forces(const Field &forces) {
    Simulation::set_external_forces(forces);
    for (Eigen::Index i = 0; i < external_forces().cols(); ++i)
        in_row(rows_.external, static_cast<int>(i)) = external_forces().col(i).cast<float>();
}

Field PositionBased::elastic_forces() const {
    if (!last_time_step_)
        return Simulation::elastic_forces();
    Field forces = Field::Zero(3, positions().cols());
    add_constraint_forces(positions(), *last_time_step_, rows_.sets, forces);
    return forces;
}

Cost PositionBased::cost(int iterations) const {
    const auto num_tetrahedra = static_cast<double>(scene().body->mesh.tetrahedra.size());
    return {.element_passes = 1.0 * iterations,
            .bytes_per_element = static_cast<double>(rows_.bytes()) / num_tetrahedra};
}

} // namespace livermark::interactive
