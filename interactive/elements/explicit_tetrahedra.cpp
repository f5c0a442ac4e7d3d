#include "interactive/elements/explicit_tetrahedra.hpp"

#include <utility>

#include "interactive/elements/critical_step.hpp"
#include "interactive/elements/rows_of_nodes.hpp"
#include "interactive/elements/tetrahedra.hpp"
#include "interactive/kernels/explicit_steps.hpp"

namespace livermark::interactive {

namespace {

/// The nodes of a step as rows keep them.
class NodesInRows : public core::MovingNodes {
  public:
    /// @param time_step  h of the step [s]
    NodesInRows(kernels::ExplicitRows &rows, double time_step) : rows_(rows), time_step_(time_step) {}

    void displacements(std::span<const int> nodes, std::span<core::Vector3> found) const override {
        for (std::size_t i = 0; i < nodes.size(); ++i)
            found[i] = in_row(std::as_const(rows_.displacement), rows_.row_of_node[nodes[i]]).cast<double>();
    }
    void kick(std::span<const int> nodes, std::span<const core::Vector3> velocity, double /*h*/) override {
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            in_row(rows_.displacement, rows_.row_of_node[nodes[i]]) += (time_step_ * velocity[i]).cast<float>();
            in_row(rows_.velocity, rows_.row_of_node[nodes[i]]) += velocity[i].cast<float>();
        }
    }

  private:
    kernels::ExplicitRows &rows_;
    double time_step_;
};

} // namespace

ExplicitTetrahedra::ExplicitTetrahedra(Scene given, kernels::Pressure pressure)
    : Simulation(std::move(given)), pressure_(pressure), rest_(positions()),
      rows_(kernels::explicit_rows(scene(), pressure_)) {}

void ExplicitTetrahedra::step(double time_step, int iterations) {
    rows_.aim_constrained(scene(), rest_, positions(), targets(), time_step);
    const double h = time_step / iterations;
    if (!correction_ && !ball_ && !after_step_)
        kernels::take_explicit_steps(rows_, h, scene().mass_damping, iterations);
    else
        for (int i = 0; i < iterations; ++i) {
            if (correction_)
                take_corrected_step(h);
            else
                kernels::take_explicit_steps(rows_, h, scene().mass_damping, 1);
            if (ball_)
                push_out(ball_->part(i, iterations), h);
            if (after_step_) {
                NodesInRows nodes(rows_, h);
                after_step_(nodes, static_cast<double>(i + 1) / iterations, h);
            }
        }
    auto &x = mutable_positions();
    take_from_rows(rows_.displacement, rows_.row_of_node, x);
    x += rest_;
    take_from_rows(rows_.velocity, rows_.row_of_node, mutable_velocities());
    move_to_targets(); // to the last bit
}

double ExplicitTetrahedra::critical_time_step() const {
    if (!critical_time_step_)
        critical_time_step_ = interactive::critical_time_step(energy(), scene());
    return *critical_time_step_;
}

bool ExplicitTetrahedra::correct_steps(const std::shared_ptr<StepCorrection> &correction) {
    correction_ = correction;
    return true;
}

bool ExplicitTetrahedra::touch(const std::shared_ptr<core::BallContact> &ball) {
    ball_ = ball;
    return true;
}

bool ExplicitTetrahedra::act_after_steps(const AfterStep &action) {
    after_step_ = action;
    return true;
}

void ExplicitTetrahedra::set_state(const Field &positions, const Field &velocities) {
    Simulation::set_state(positions, velocities);
    put_into_rows(positions - rest_, rows_.row_of_node, rows_.displacement);
    put_into_rows(velocities, rows_.row_of_node, rows_.velocity);
}

void ExplicitTetrahedra::set_external_forces(const Field &forces) {
    Simulation::set_external_forces(forces);
    put_into_rows(external_forces(), rows_.row_of_node, rows_.external);
}

Cost ExplicitTetrahedra::cost(int iterations) const {
    const double passes = pressure_ == kernels::Pressure::around_nodes ? 2.0 : 1.0;
    const auto num_tetrahedra = static_cast<double>(scene().body->mesh.tetrahedra.size());
    return {.element_passes = passes * iterations,
            .bytes_per_element = static_cast<double>(rows_.bytes()) / num_tetrahedra};
}

/// After a step of length h.
void ExplicitTetrahedra::push_out(const core::BallStep &step, double h) {
    const auto position = [&](int n) {
        return FineRow(rest_.col(n), in_row(rows_.displacement, rows_.row_of_node[n]));
    };
    const auto velocity = [&](int n) {
        return FineRow(core::Vector3::Zero(), in_row(rows_.velocity, rows_.row_of_node[n]));
    };
    const double per_mass = h * h / (1.0 + 0.5 * scene().mass_damping * h);
    const auto yields = [&](int n) { return is_free()[n] ? per_mass / scene().node_mass[n] : 0.0; };
    const auto give = [&](int n, const core::Vector3 &force) {
        const core::Vector3 way = yields(n) * force;
        position(n) += way;
        velocity(n) += way / h;
    };
    ball_->begin_step(give);
    ball_->sweep(
        step, [&](int n) { return core::Vector3(core::Vector3(position(n)) - h * core::Vector3(velocity(n))); },
        position, [&](int n) { return Matrix3(yields(n) * Matrix3::Identity()); }, give);
    ball_->end_step(h);
}

/// Steps of (1 + alpha h / 2) v = (1 - alpha h / 2) v_before + change, and of the change that is corrected.
void ExplicitTetrahedra::take_corrected_step(double h) {
    const auto &nodes = correction_->nodes();
    const auto num_nodes = static_cast<Eigen::Index>(nodes.size());
    const double half_damping = 0.5 * scene().mass_damping * h;
    const auto row = [&](kernels::Aligned<float> &rows, Eigen::Index i) {
        return in_row(rows, rows_.row_of_node[nodes[i]]);
    };
    Field x(3, num_nodes), before = x, change = x;
    for (Eigen::Index i = 0; i < num_nodes; ++i) {
        x.col(i) = rest_.col(nodes[i]) + row(rows_.displacement, i).cast<double>();
        before.col(i) = row(rows_.velocity, i).cast<double>();
    }
    kernels::take_explicit_steps(rows_, h, scene().mass_damping, 1);
    for (Eigen::Index i = 0; i < num_nodes; ++i)
        change.col(i) =
            (1.0 + half_damping) * row(rows_.velocity, i).cast<double>() - (1.0 - half_damping) * before.col(i);
    const Field uncorrected = change;
    correction_->correct(x, before, h, change);
    for (Eigen::Index i = 0; i < num_nodes; ++i) {
        const Eigen::Vector3f more = ((change.col(i) - uncorrected.col(i)) / (1.0 + half_damping)).cast<float>();
        row(rows_.velocity, i) += more;
        row(rows_.displacement, i) += static_cast<float>(h) * more;
    }
}

} // namespace livermark::interactive
