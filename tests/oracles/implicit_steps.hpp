#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/support/factors/sparse_cholesky.hpp"
#include "interactive/elements/energies.hpp"
#include "interactive/elements/implicit_elements.hpp"
#include "interactive/elements/point_springs.hpp"
#include "interactive/kernels/orders.hpp"
#include "interactive/method.hpp"

namespace livermark::tests {

using interactive::Field;
using interactive::Matrix3;

enum class Preconditioner : std::uint8_t {
    none,
    blocks ///< the inverse of the 3 x 3 block of each node (block Jacobi)
};

/// The steps of interactive::CorotationalTetrahedra in double precision and without vectors.
class Corotational : public interactive::Simulation {
  public:
    explicit Corotational(interactive::Scene given, Preconditioner preconditioner = Preconditioner::blocks)
        : Simulation(std::move(given)),
          energy_(interactive::capsule_and_vessels(scene()), interactive::tetrahedra_at_rest(*scene().body)),
          preconditioner_(preconditioner), rotations_(energy_.tetrahedra().size()),
          tangents_(energy_.point_springs().size()) {}

    void step(double time_step, int iterations) override {
        auto &x = mutable_positions();
        auto &v = mutable_velocities();
        Field forces = external_forces();
        for (std::size_t t = 0; t < rotations_.size(); ++t) {
            const auto &tetrahedron = energy_.tetrahedra()[t];
            const Matrix3 gradient = tetrahedron.gradient(x);
            rotations_[t] = interactive::densities::rotation(gradient);
            const interactive::densities::Corotational density{tetrahedron.mu, tetrahedron.lambda};
            tetrahedron.add_forces(density.stress(gradient, rotations_[t]), forces);
        }
        for (std::size_t s = 0; s < tangents_.size(); ++s) {
            const auto &spring = energy_.point_springs()[s];
            const core::Vector3 span = spring.span(x);
            tangents_[s] = spring.law().tangent(span, true);
            for (std::size_t a = 0; a < spring.nodes.size(); ++a)
                forces.col(spring.nodes[a]) -= spring.weights[a] * spring.law().pull(span);
        }
        Field right = time_step * forces;
        for (Eigen::Index i = 0; i < x.cols(); ++i)
            right.col(i) += scene().node_mass[i] * v.col(i);
        for (Eigen::Index c = 0; c < targets().cols(); ++c) {
            const int node = scene().constrained_nodes[c];
            v.col(node) = (targets().col(c) - x.col(node)) / time_step;
        }
        if (ball_)
            solve_touched(right, time_step, iterations);
        else
            solve(right, time_step, iterations);
        x += time_step * v;
        move_to_targets(); // to the last bit
    }

    bool touch(const std::shared_ptr<core::BallContact> &ball) override {
        ball_ = ball;
        return true;
    }
    const interactive::Energy &energy() const override { return energy_; }
    interactive::Cost cost(int /*iterations*/) const override { return {}; }

  private:
    /// Solves until what touches and slips is what was solved for.
    void solve_touched(const Field &right, double time_step, int iterations) {
        constexpr int most_solutions = 5;
        auto &v = mutable_velocities();
        const Field velocities = v;
        const auto now = [&](int node) { return core::Vector3(positions().col(node) + time_step * v.col(node)); };
        contact_.begin(*ball_, [&](int node) { return positions().col(node); });
        contact_.linearise(now);
        for (int s = 0; s < most_solutions; ++s) {
            Field pushed = right;
            for (const auto &point : contact_.points())
                for (std::size_t k = 0; k < 3; ++k)
                    pushed.col(point.nodes[k]) += time_step * point.shape[k] * point.force;
            v = velocities;
            solve(pushed, time_step, iterations);
            if (!contact_.linearise(now))
                break;
        }
        contact_.finish(*ball_, now);
        ball_->end_step(time_step);
    }

    /// A v, zero at constrained nodes.
    Field product(const Field &v, double time_step) const {
        Field forces = Field::Zero(3, v.cols());
        for (std::size_t t = 0; t < rotations_.size(); ++t) { // K v, as forces of minus that
            const auto &tetrahedron = energy_.tetrahedra()[t];
            const Matrix3 rate = rotations_[t].transpose() * tetrahedron.gradient(v);
            Matrix3 stress = tetrahedron.mu * (rate + rate.transpose());
            stress.diagonal().array() += tetrahedron.lambda * rate.trace();
            tetrahedron.add_forces(rotations_[t] * stress, forces);
        }
        for (std::size_t s = 0; s < tangents_.size(); ++s) {
            const auto &spring = energy_.point_springs()[s];
            const core::Vector3 pull = tangents_[s] * spring.span(v);
            for (std::size_t a = 0; a < spring.nodes.size(); ++a)
                forces.col(spring.nodes[a]) -= spring.weights[a] * pull;
        }
        if (ball_)
            for (const auto &point : contact_.points()) {
                core::Vector3 rate = core::Vector3::Zero();
                for (std::size_t k = 0; k < 3; ++k)
                    rate += point.shape[k] * v.col(point.nodes[k]);
                for (std::size_t k = 0; k < 3; ++k)
                    forces.col(point.nodes[k]) -= point.shape[k] * (point.stiffness * rate);
            }
        Field result = -time_step * time_step * forces;
        for (Eigen::Index i = 0; i < v.cols(); ++i)
            result.col(i) += (1.0 + scene().mass_damping * time_step) * scene().node_mass[i] * v.col(i);
        for (const int node : scene().constrained_nodes)
            result.col(node).setZero();
        return result;
    }

    /// Diagonal blocks of A, with K_aa = sum of V ((lambda + mu) g g^T + mu |g|^2 1), g the turned gradient of the
    /// shape function.
    std::vector<Matrix3> inverse_blocks(double time_step) const {
        std::vector<Matrix3> blocks;
        for (const double mass : scene().node_mass)
            blocks.emplace_back((1.0 + scene().mass_damping * time_step) * mass * Matrix3::Identity());
        for (std::size_t t = 0; t < rotations_.size(); ++t) {
            const auto &tetrahedron = energy_.tetrahedra()[t];
            const Eigen::Matrix<double, 3, 4> turned = rotations_[t] * tetrahedron.shape_gradients().transpose();
            const double factor = time_step * time_step * tetrahedron.volume;
            for (int c = 0; c < 4; ++c) {
                auto &block = blocks[tetrahedron.nodes[c]];
                block += factor * (tetrahedron.lambda + tetrahedron.mu) * turned.col(c) * turned.col(c).transpose();
                block.diagonal().array() += factor * tetrahedron.mu * turned.col(c).squaredNorm();
            }
        }
        for (std::size_t s = 0; s < tangents_.size(); ++s) {
            const auto &spring = energy_.point_springs()[s];
            for (std::size_t a = 0; a < spring.nodes.size(); ++a)
                blocks[spring.nodes[a]] += time_step * time_step * spring.weights[a] * spring.weights[a] * tangents_[s];
        }
        if (ball_)
            for (const auto &point : contact_.points())
                for (std::size_t k = 0; k < 3; ++k)
                    blocks[point.nodes[k]] += time_step * time_step * point.shape[k] * point.shape[k] * point.stiffness;
        for (auto &block : blocks)
            block = block.inverse().eval();
        return blocks;
    }

    /// Conjugate gradients for A v = right, from v.
    void solve(const Field &right, double time_step, int iterations) {
        constexpr double rounding = 1e-32; // of squares: there is nothing left to do
        auto &v = mutable_velocities();
        const auto blocks =
            preconditioner_ == Preconditioner::blocks ? inverse_blocks(time_step) : std::vector<Matrix3>();
        const auto preconditioned = [&](Field residual) {
            for (std::size_t i = 0; i < blocks.size(); ++i)
                residual.col(static_cast<Eigen::Index>(i)) =
                    (blocks[i] * residual.col(static_cast<Eigen::Index>(i))).eval();
            return residual;
        };
        Field residual = right - product(v, time_step);
        for (const int node : scene().constrained_nodes)
            residual.col(node).setZero();
        Field direction = preconditioned(residual);
        const double first = residual.cwiseProduct(direction).sum();
        double squared = first;
        for (int i = 0; i < iterations && squared > rounding * first; ++i) {
            const Field along = product(direction, time_step);
            const double length = squared / direction.cwiseProduct(along).sum();
            v += length * direction;
            residual -= length * along;
            const Field next_direction = preconditioned(residual);
            const double next = residual.cwiseProduct(next_direction).sum();
            direction = next_direction + next / squared * direction;
            squared = next;
        }
    }

    interactive::WithSprings<interactive::ElementEnergy<interactive::densities::Corotational>> energy_;
    Preconditioner preconditioner_;
    std::vector<Matrix3> rotations_; ///< (M) where the step began
    std::vector<Matrix3> tangents_;  ///< of springs beside the tetrahedra, there
    std::shared_ptr<core::BallContact> ball_;
    interactive::ImplicitContact contact_; ///< of the ball
};

/// The steps of interactive::Prefactored with the forces of any energy, in double precision and without vectors.
class Prefactored : public interactive::Simulation {
  public:
    /// @param laplacian  L, unknown i for node i, both triangles
    Prefactored(interactive::Scene given, interactive::Energy::Triplets laplacian)
        : Simulation(std::move(given)), laplacian_(std::move(laplacian)) {}

    void step(double time_step, int iterations) override {
        const auto terms = interactive::inertia(*this, time_step);
        factorise(terms, time_step);
        auto &x = mutable_positions();
        const Field before = x;
        x = terms.predicted;
        std::vector<core::Vector3> pushes(static_cast<std::size_t>(x.cols()), core::Vector3::Zero()); // of the ball
        for (int k = 0; k < iterations && num_unknowns_ > 0; ++k) {
            Field forces = Field::Zero(3, x.cols());
            energy().add_forces(x, forces);
            for (Eigen::Index i = 0; i < x.cols(); ++i)
                forces.col(i) += pushes[i] - terms.stiffness[i] * (x.col(i) - terms.predicted.col(i));
            x += solution(forces);
            if (ball_)
                touch_nodes(before, pushes, k == 0);
        }
        mutable_velocities() = (x - before) / time_step;
        if (ball_)
            ball_->end_step(time_step);
    }

    bool touch(const std::shared_ptr<core::BallContact> &ball) override {
        ball_ = ball;
        return true;
    }

  private:
    void factorise(const interactive::Inertia &terms, double time_step) {
        if (time_step == factorised_for_)
            return;
        factorised_for_ = time_step;
        unknown_.assign(terms.stiffness.size(), -1);
        num_unknowns_ = 0;
        for (std::size_t i = 0; i < unknown_.size(); ++i)
            if (is_free()[i])
                unknown_[i] = num_unknowns_++;
        interactive::Energy::Triplets kept;
        for (const auto &entry : laplacian_)
            if (unknown_[entry.row()] >= 0 && unknown_[entry.col()] >= unknown_[entry.row()])
                kept.emplace_back(unknown_[entry.row()], unknown_[entry.col()], entry.value());
        for (std::size_t i = 0; i < unknown_.size(); ++i)
            if (unknown_[i] >= 0)
                kept.emplace_back(unknown_[i], unknown_[i], terms.stiffness[i]);
        Eigen::SparseMatrix<double> matrix(num_unknowns_, num_unknowns_);
        matrix.setFromTriplets(kept.begin(), kept.end());
        if (num_unknowns_ > 0) {
            factor_.order(matrix);
            factor_.factorise(matrix);
        }
    }

    /// A^-1 f, zero at constrained nodes.
    Field solution(const Field &forces) const {
        Eigen::MatrixXd right(num_unknowns_, 3);
        for (Eigen::Index i = 0; i < forces.cols(); ++i)
            if (unknown_[i] >= 0)
                right.row(unknown_[i]) = forces.col(i).transpose();
        const Eigen::MatrixXd solved = factor_.solve(right);
        Field result = Field::Zero(3, forces.cols());
        for (Eigen::Index i = 0; i < forces.cols(); ++i)
            if (unknown_[i] >= 0)
                result.col(i) = solved.row(unknown_[i]).transpose();
        return result;
    }

    /// Finds the forces of the ball that go with where an iteration has brought the nodes, and moves all by these.
    void touch_nodes(const Field &before, std::vector<core::Vector3> &pushes, bool is_first) {
        constexpr int most_sweeps = 20;
        constexpr double steady = 1e-3; // as the sweeps of an iteration end: the next ones go on
        const auto &near = ball_->near();
        std::vector<Eigen::VectorXd> column(unknown_.size()); // of A^-1 for all nodes near the ball
        for (const int node : near)
            if (unknown_[node] >= 0)
                column[node] = factor_.solve(Eigen::MatrixXd(Eigen::VectorXd::Unit(num_unknowns_, unknown_[node])));
        const auto compliance = [&](int a, int b) {
            return unknown_[a] >= 0 && unknown_[b] >= 0 ? column[a][unknown_[b]] : 0.0;
        };
        Field x = positions(), change = Field::Zero(3, x.cols());
        const auto give = [&](int node, const core::Vector3 &force) {
            change.col(node) += force;
            for (const int other : near)
                x.col(other) += compliance(node, other) * force;
        };
        const auto yields = [&](const std::array<int, 3> &nodes, const std::array<double, 3> &shape) {
            double sum = 0.0;
            for (std::size_t a = 0; a < 3; ++a)
                for (std::size_t b = 0; b < 3; ++b)
                    sum += shape[a] * shape[b] * compliance(nodes[a], nodes[b]);
            return Matrix3(sum * Matrix3::Identity());
        };
        if (is_first)
            ball_->begin_step(give);
        const auto start = [&](int node) { return core::Vector3(before.col(node)); };
        const auto now = [&](int node) { return core::Vector3(x.col(node)); };
        const auto step = ball_->part(0, 1);
        for (int s = 0; s < most_sweeps && ball_->sweep(step, start, now, yields, give) > steady; ++s) {
        }
        for (const int node : near)
            pushes[node] += change.col(node);
        mutable_positions() += solution(change);
    }

    interactive::Energy::Triplets laplacian_;
    support::SparseCholesky factor_;
    double factorised_for_ = 0.0; ///< time step [s]
    std::vector<int> unknown_;    ///< (N) of a node, -1 where constrained
    int num_unknowns_ = 0;
    std::shared_ptr<core::BallContact> ball_;
};

/// The steps of vertex_block_descent in double precision and without vectors.
class BlockDescent : public interactive::Simulation {
  public:
    /// @param node_colour  (N): nodes are visited in this order
    BlockDescent(interactive::Scene given, const std::vector<int> &node_colour)
        : Simulation(std::move(given)),
          energy_(interactive::capsule_and_vessels(scene()), interactive::tetrahedra_at_rest(*scene().body)),
          around_(static_cast<std::size_t>(positions().cols())),
          springs_at_(interactive::springs_at_nodes(energy_.point_springs(), around_.size())),
          last_velocities_(velocities()) {
        for (std::size_t t = 0; t < energy_.tetrahedra().size(); ++t)
            for (const int node : energy_.tetrahedra()[t].nodes)
                around_[node].push_back(static_cast<int>(t));
        for (const int node : interactive::by_colours(node_colour).order)
            if (is_free()[node])
                order_.push_back(node);
    }

    void step(double time_step, int iterations) override {
        auto &x = mutable_positions();
        auto &v = mutable_velocities();
        const Field before = x;
        const auto terms = interactive::inertia(*this, time_step);
        start(terms, time_step);
        auto pushed = terms;
        std::vector<core::Vector3> forces(static_cast<std::size_t>(x.cols()), core::Vector3::Zero()); // of the ball
        const double rho = interactive::chebyshev_rho(iterations);
        double weight = 1.0;
        Field older, oldest;
        for (int i = 1; i <= iterations; ++i) {
            weight = interactive::chebyshev_weight(i, weight, rho);
            oldest = std::move(older);
            older = x;
            for (const int node : order_) {
                const auto [gradient, hessian] = slope_at(pushed, node);
                x.col(node) -= hessian.inverse() * gradient;
            }
            if (i > 1)
                x = weight * (x - oldest) + oldest;
            if (ball_) {
                touch_nodes(before, pushed, forces, i == 1);
                for (const int node : ball_->near())
                    if (is_free()[node])
                        pushed.predicted.col(node) = terms.predicted.col(node) + forces[node] / terms.stiffness[node];
            }
        }
        last_velocities_ = v;
        v = (x - before) / time_step;
        if (ball_)
            ball_->end_step(time_step);
    }

    void set_state(const Field &positions, const Field &velocities) override {
        Simulation::set_state(positions, velocities);
        last_velocities_ = velocities;
    }
    bool touch(const std::shared_ptr<core::BallContact> &ball) override {
        ball_ = ball;
        return true;
    }
    const interactive::Energy &energy() const override { return energy_; }
    interactive::Cost cost(int /*iterations*/) const override { return {}; }

  private:
    /// The start of iterations: where the velocity goes, and the external acceleration as far as the last step followed
    /// it (section 3.7 of the paper: less where a body rests).
    void start(const interactive::Inertia &terms, double time_step) {
        auto &x = mutable_positions();
        for (Eigen::Index i = 0; i < x.cols(); ++i) {
            if (!is_free()[i]) {
                x.col(i) = terms.predicted.col(i);
                continue;
            }
            const core::Vector3 external = external_forces().col(i) / scene().node_mass[i];
            const double size = external.norm();
            core::Vector3 move = time_step * velocities().col(i);
            if (size > 0.0) {
                const core::Vector3 last = (velocities().col(i) - last_velocities_.col(i)) / time_step;
                move += time_step * time_step * std::clamp(last.dot(external) / (size * size), 0.0, 1.0) * external;
            }
            x.col(i) += move;
        }
    }

    struct Slope {
        core::Vector3 gradient; ///< [N]
        Matrix3 hessian;        ///< [N/m]
    };

    Slope slope_at(const interactive::Inertia &terms, int node) const {
        const auto &x = positions();
        core::Vector3 gradient = terms.stiffness[node] * (x.col(node) - terms.predicted.col(node));
        Matrix3 hessian = terms.stiffness[node] * Matrix3::Identity();
        for (const int number : around_[node]) {
            const auto &t = energy_.tetrahedra()[number];
            const core::Vector3 slope =
                t.shape_gradients().row(std::ranges::find(t.nodes, node) - t.nodes.begin()).transpose();
            const Matrix3 f = t.gradient(x);
            const double volume_modulus = t.lambda + t.mu;
            const core::Vector3 turned = interactive::cofactors(f) * slope;
            gradient += t.volume * (t.mu * (f * slope) + (volume_modulus * (f.determinant() - 1.0) - t.mu) * turned);
            hessian += (t.volume * volume_modulus) * turned * turned.transpose();
            hessian.diagonal().array() += t.volume * t.mu * slope.squaredNorm();
        }
        for (const auto &[number, place] : springs_at_[node]) {
            const auto &spring = energy_.point_springs()[number];
            const double weight = spring.weights[place];
            gradient += weight * spring.law().pull(spring.span(x));
            hessian += weight * weight * spring.law().tangent(spring.span(x), true);
        }
        return {gradient, hessian};
    }

    /// One sweep over the points that the ball is near to. Nodes give way as their own quadratic says.
    void touch_nodes(const Field &before, const interactive::Inertia &terms, std::vector<core::Vector3> &forces,
                     bool is_first) {
        auto &x = mutable_positions();
        std::vector<std::optional<Matrix3>> found(static_cast<std::size_t>(x.cols()));
        const auto yields = [&](int node) -> Matrix3 {
            if (!is_free()[node])
                return Matrix3::Zero();
            if (!found[node])
                found[node] = Matrix3(slope_at(terms, node).hessian.inverse());
            return *found[node];
        };
        const auto give = [&](int node, const core::Vector3 &force) {
            forces[node] += force;
            x.col(node) += yields(node) * force;
        };
        if (is_first)
            ball_->begin_step(give);
        ball_->sweep(
            ball_->part(0, 1), [&](int node) { return core::Vector3(before.col(node)); },
            [&](int node) { return x.col(node); }, yields, give);
    }

    interactive::WithSprings<interactive::ElementEnergy<interactive::densities::StableNeoHookean>> energy_;
    std::vector<std::vector<int>> around_;                        ///< (N) tetrahedra
    std::vector<std::vector<interactive::SpringEnd>> springs_at_; ///< (N) beside them
    std::vector<int> order_;                                      ///< of free nodes
    Field last_velocities_;                                       ///< those before the last step
    std::shared_ptr<core::BallContact> ball_;
};

} // namespace livermark::tests
