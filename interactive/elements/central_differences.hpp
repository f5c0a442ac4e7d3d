#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "interactive/elements/critical_step.hpp"
#include "interactive/simulation.hpp"

namespace livermark::interactive {

/// Explicit steps with the forces of the energy. An iteration is one step of central differences, h = time step over
/// iterations, with velocities half a step behind:
///     v = ((1 - alpha h / 2) v + h (f + f_ext) / m) / (1 + alpha h / 2),   x += h v.
/// Constrained nodes go to their targets in equal parts. Longer steps than critical_time_step() blow up. What a ball
/// that touches exerts takes part in the step. What acts after a step is given the nodes of the mesh alone.
/// (Belytschko, Liu, Moran 2000, Nonlinear Finite Elements for Continua and Structures, box 6.1 and section 10.7)
class CentralDifferences : public Simulation {
  public:
    explicit CentralDifferences(Scene given) : Simulation(std::move(given)), forces_(rest_positions(scene())) {}

    void step(double time_step, int iterations) override {
        auto &x = mutable_positions();
        auto &v = mutable_velocities();
        Field moved = x;
        put_constrained(scene(), targets(), moved);
        for (Eigen::Index n = 0; n < x.cols(); ++n)
            if (!is_free()[n])
                v.col(n) = (moved.col(n) - x.col(n)) / time_step;
        const double h = time_step / iterations;
        const double half_damping = 0.5 * scene().mass_damping * h;
        for (int i = 0; i < iterations; ++i) {
            forces_ = external_forces();
            energy().add_forces(x, forces_);
            if (correction_)
                correct_forces(h);
            for (Eigen::Index n = 0; n < x.cols(); ++n)
                if (is_free()[n])
                    v.col(n) = ((1.0 - half_damping) * v.col(n) + h / scene().node_mass[n] * forces_.col(n)) /
                               (1.0 + half_damping);
            x += h * v;
            if (ball_)
                push_out(
                    ball_->part(i, iterations), h, [&](int n) { return x.col(n); }, [&](int n) { return v.col(n); });
            if (after_step_) {
                NodesOfStep nodes([&](int n) -> core::Vector3 { return x.col(n) - rest_of(n); },
                                  [&](int n, const core::Vector3 &change) {
                                      x.col(n) += h * change;
                                      v.col(n) += change;
                                  });
                after_step_(nodes, static_cast<double>(i + 1) / iterations, h);
            }
        }
        move_to_targets(); // to the last bit
    }

    /// Found when it is asked for.
    double critical_time_step() const override {
        if (!critical_time_step_)
            critical_time_step_ = interactive::critical_time_step(energy(), scene());
        return *critical_time_step_;
    }

    bool correct_steps(const std::shared_ptr<StepCorrection> &correction) override {
        correction_ = correction;
        return true;
    }

    bool touch(const std::shared_ptr<core::BallContact> &ball) override {
        ball_ = ball;
        return true;
    }

    bool act_after_steps(const AfterStep &action) override {
        after_step_ = action;
        return true;
    }

  protected:
    /// The nodes of a step as they are kept.
    /// @tparam Displacement  int -> Vector3 [m]
    /// @tparam Kick          (int, Vector3 [m/s]), of a node that is free to move
    template <class Displacement, class Kick> class NodesOfStep : public core::MovingNodes {
      public:
        NodesOfStep(Displacement displacement, Kick kick)
            : displacement_(std::move(displacement)), kick_(std::move(kick)) {}

        void displacements(std::span<const int> nodes, std::span<core::Vector3> found) const override {
            for (std::size_t i = 0; i < nodes.size(); ++i)
                found[i] = displacement_(nodes[i]);
        }
        void kick(std::span<const int> nodes, std::span<const core::Vector3> velocity, double /*h*/) override {
            for (std::size_t i = 0; i < nodes.size(); ++i)
                kick_(nodes[i], velocity[i]);
        }

      private:
        Displacement displacement_;
        Kick kick_;
    };

    const AfterStep &after_step() const { return after_step_; }
    /// Null if there is none.
    StepCorrection *correction() const { return correction_.get(); }
    core::BallContact *ball() const { return ball_.get(); }

    /// After a step of length h.
    /// @param position  of a node: int -> something that can be added to, and
    /// @param velocity  the same, with v half a step behind
    template <class Position, class Velocity>
    void push_out(const core::BallStep &step, double h, const Position &position, const Velocity &velocity) {
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

  private:
    /// To those that change velocities by what is corrected.
    void correct_forces(double h) {
        const auto &nodes = correction_->nodes();
        const auto num_nodes = static_cast<Eigen::Index>(nodes.size());
        Field x(3, num_nodes), v = x, change = x;
        for (Eigen::Index i = 0; i < num_nodes; ++i) {
            x.col(i) = positions().col(nodes[i]);
            v.col(i) = velocities().col(nodes[i]);
            change.col(i) = h / scene().node_mass[nodes[i]] * forces_.col(nodes[i]);
        }
        correction_->correct(x, v, h, change);
        for (Eigen::Index i = 0; i < num_nodes; ++i)
            forces_.col(nodes[i]) = scene().node_mass[nodes[i]] / h * change.col(i);
    }

    std::shared_ptr<StepCorrection> correction_;
    core::Vector3 rest_of(int node) const { return scene().body->mesh.points[static_cast<std::size_t>(node)]; }

    std::shared_ptr<core::BallContact> ball_;
    AfterStep after_step_;
    Field forces_;
    mutable std::optional<double> critical_time_step_;
};

} // namespace livermark::interactive
