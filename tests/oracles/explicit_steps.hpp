#pragma once

#include <memory>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "interactive/elements/position_based.hpp"
#include "interactive/method.hpp"

namespace livermark::tests {

/// The steps of interactive::ExplicitTetrahedra with the forces of any energy, in double precision and without vectors.
class CentralDifferences : public interactive::Simulation {
  public:
    explicit CentralDifferences(interactive::Scene given) : Simulation(std::move(given)) {}

    void step(double time_step, int iterations) override {
        auto &x = mutable_positions();
        auto &v = mutable_velocities();
        interactive::Field moved = x;
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
                push_out(ball_->part(i, iterations), h);
        }
        move_to_targets(); // to the last bit
    }

    bool correct_steps(const std::shared_ptr<interactive::StepCorrection> &correction) override {
        correction_ = correction;
        return true;
    }

    bool touch(const std::shared_ptr<core::BallContact> &ball) override {
        ball_ = ball;
        return true;
    }

  private:
    /// After a step of length h.
    void push_out(const core::BallStep &step, double h) {
        auto &x = mutable_positions();
        auto &v = mutable_velocities();
        const double per_mass = h * h / (1.0 + 0.5 * scene().mass_damping * h);
        const auto yields = [&](int n) { return is_free()[n] ? per_mass / scene().node_mass[n] : 0.0; };
        const auto give = [&](int n, const core::Vector3 &force) {
            const core::Vector3 way = yields(n) * force;
            x.col(n) += way;
            v.col(n) += way / h;
        };
        ball_->begin_step(give);
        ball_->sweep(
            step, [&](int n) { return core::Vector3(x.col(n) - h * v.col(n)); }, [&](int n) { return x.col(n); },
            [&](int n) { return Eigen::Matrix3d(yields(n) * Eigen::Matrix3d::Identity()); }, give);
        ball_->end_step(h);
    }

    /// To those that change velocities by what is corrected.
    void correct_forces(double h) {
        const auto &nodes = correction_->nodes();
        const auto num_nodes = static_cast<Eigen::Index>(nodes.size());
        interactive::Field x(3, num_nodes), v = x, change = x;
        for (Eigen::Index i = 0; i < num_nodes; ++i) {
            x.col(i) = positions().col(nodes[i]);
            v.col(i) = velocities().col(nodes[i]);
            change.col(i) = h / scene().node_mass[nodes[i]] * forces_.col(nodes[i]);
        }
        correction_->correct(x, v, h, change);
        for (Eigen::Index i = 0; i < num_nodes; ++i)
            forces_.col(nodes[i]) = scene().node_mass[nodes[i]] / h * change.col(i);
    }

    std::shared_ptr<interactive::StepCorrection> correction_;
    std::shared_ptr<core::BallContact> ball_;
    interactive::Field forces_;
};

/// Constraints of one kind, which one iteration visits one after the other as interactive::ConstraintSet says.
template <class Kind> class Constraints {
  public:
    static constexpr int num_nodes = Kind::num_nodes;
    using Vector = Eigen::Matrix<double, Kind::num_constraints, 1>;
    using Gradients = Eigen::Matrix<double, 3 * num_nodes, Kind::num_constraints>;

    /// @param colours  (M) of each: they are visited in this order
    Constraints(const std::vector<Kind> &kinds, const std::vector<int> &colours) : multipliers_(kinds.size()) {
        for (const int k : interactive::by_colours(colours).order)
            kinds_.push_back(kinds[k]);
    }

    void clear() {
        for (auto &multiplier : multipliers_)
            multiplier.setZero();
    }

    /// @param inverse_mass  (N) [1/kg], zero where a node does not move
    void project(interactive::Field &x, const std::vector<double> &inverse_mass, double time_step) {
        Vector c;
        Gradients g, weighted;
        for (std::size_t k = 0; k < kinds_.size(); ++k) {
            const auto &kind = kinds_[k];
            kind.evaluate(x, c, g);
            for (int a = 0; a < num_nodes; ++a)
                weighted.template middleRows<3>(3 * a) = inverse_mass[kind.nodes[a]] * g.template middleRows<3>(3 * a);
            const Vector compliance = kind.compliance / (time_step * time_step);
            Eigen::Matrix<double, Kind::num_constraints, Kind::num_constraints> matrix = g.transpose() * weighted;
            matrix.diagonal() += compliance;
            const Vector change = matrix.inverse() * (-c - compliance.cwiseProduct(multipliers_[k]));
            multipliers_[k] += change;
            const Eigen::Matrix<double, 3 * num_nodes, 1> move = weighted * change;
            for (int a = 0; a < num_nodes; ++a)
                x.col(kind.nodes[a]) += move.template segment<3>(3 * a);
        }
    }

    /// f += g lambda / h^2 [N]
    void add_forces(const interactive::Field &x, double time_step, interactive::Field &f) const {
        Vector c;
        Gradients g;
        for (std::size_t k = 0; k < kinds_.size(); ++k) {
            kinds_[k].evaluate(x, c, g);
            const Eigen::Matrix<double, 3 * num_nodes, 1> force = g * multipliers_[k] / (time_step * time_step);
            for (int a = 0; a < num_nodes; ++a)
                f.col(kinds_[k].nodes[a]) += force.template segment<3>(3 * a);
        }
    }

  private:
    std::vector<Kind> kinds_; ///< in the order of their colours
    std::vector<Vector> multipliers_;
};

/// The steps of interactive::PositionBased in double precision and without vectors.
/// @tparam Sets  a tuple of Constraints
template <class Sets> class PositionBased : public interactive::Simulation {
  public:
    PositionBased(interactive::Scene given, Sets sets) : Simulation(std::move(given)), sets_(std::move(sets)) {}

    void step(double time_step, int iterations) override {
        auto &x = mutable_positions();
        const interactive::Field before = x;
        const auto terms = interactive::inertia(*this, time_step);
        std::vector<double> inverse_mass(scene().node_mass.size());
        for (std::size_t i = 0; i < inverse_mass.size(); ++i)
            inverse_mass[i] = is_free()[i] ? 1.0 / (terms.stiffness[i] * time_step * time_step) : 0.0;
        x = terms.predicted;
        std::apply([](auto &...set) { (set.clear(), ...); }, sets_);
        for (int i = 0; i < iterations; ++i) {
            std::apply([&](auto &...set) { (set.project(x, inverse_mass, time_step), ...); }, sets_);
            if (ball_)
                project_ball(before, inverse_mass, time_step, i == 0);
        }
        mutable_velocities() = (x - before) / time_step;
        if (ball_)
            ball_->end_step(time_step);
        last_time_step_ = time_step;
    }

    void set_state(const interactive::Field &positions, const interactive::Field &velocities) override {
        Simulation::set_state(positions, velocities);
        last_time_step_.reset();
    }

    bool touch(const std::shared_ptr<core::BallContact> &ball) override {
        ball_ = ball;
        return true;
    }

    interactive::Field elastic_forces() const override {
        if (!last_time_step_)
            return Simulation::elastic_forces();
        interactive::Field forces = interactive::Field::Zero(3, positions().cols());
        std::apply([&](const auto &...set) { (set.add_forces(positions(), *last_time_step_, forces), ...); }, sets_);
        return forces;
    }

  private:
    void project_ball(const interactive::Field &before, const std::vector<double> &inverse_mass, double time_step,
                      bool is_first) {
        auto &x = mutable_positions();
        const auto yields = [&](int n) { return inverse_mass[n] * time_step * time_step; };
        const auto give = [&](int n, const core::Vector3 &force) { x.col(n) += yields(n) * force; };
        if (is_first)
            ball_->begin_step(give);
        ball_->sweep(
            ball_->part(0, 1), [&](int n) { return before.col(n); }, [&](int n) { return x.col(n); },
            [&](int n) { return Eigen::Matrix3d(yields(n) * Eigen::Matrix3d::Identity()); }, give);
    }

    Sets sets_;
    std::shared_ptr<core::BallContact> ball_;
    std::optional<double> last_time_step_; ///< [s]
};

} // namespace livermark::tests
