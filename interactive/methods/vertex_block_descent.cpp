#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "interactive/chebyshev.hpp"
#include "interactive/colouring.hpp"
#include "interactive/elements/energies/element_energy.hpp"
#include "interactive/elements/rows_of_nodes.hpp"
#include "interactive/inertia.hpp"
#include "interactive/kernels/descent/descent_steps.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

namespace {

/// Backward Euler by descent on one node at a time: an iteration visits the nodes in the order of their colours, and
/// moves each by -H^-1 g of its own three unknowns, with the nodes around it where they are. W is quadratic along F and
/// J is linear in each node, so H = k + sum of V (mu |b|^2 + (lambda + mu) (c b) (c b)^T), with b the gradient of the
/// shape function and c the cofactors of F, is positive definite. Iterations are accelerated by Chebyshev's weights.
/// After each, a ball that touches is met by one point of a facet after the other, in double precision, with nodes that
/// give way by H^-1.
class VertexBlockDescent : public Simulation {
  public:
    explicit VertexBlockDescent(Scene given)
        : Simulation(std::move(given)), energy_(tetrahedra_at_rest(*scene().body)), rest_(positions()),
          node_colour_(colours()), offsets_{0}, last_velocities_(velocities()) {
        const auto colours = by_colours(node_colour_);
        if (scene().precision == Precision::single_precision) {
            rows_ = kernels::descent_rows(scene(), colours);
            return;
        }
        const auto around = tetrahedra_around();
        for (const int node : colours.order)
            if (is_free()[node])
                add_node(node, around[node]);
    }

    bool touch(const std::shared_ptr<core::BallContact> &ball) override {
        ball_ = ball;
        if (rows_)
            rows_->after_iteration = nullptr;
        if (!ball_)
            return true;
        if (rows_ && nodes_.empty()) { // single precision has its own corners, but for nodes that are touched
            const auto around = tetrahedra_around();
            for (const int node : ball_->nodes())
                if (is_free()[node])
                    add_node(node, around[node]);
        }
        if (rows_)
            rows_->after_iteration = [this] { touch_rows(); };
        return true;
    }

    void step(double time_step, int iterations) override {
        if (ball_)
            forces_.assign(static_cast<std::size_t>(positions().cols()), core::Vector3::Zero());
        has_touched_ = false;
        if (rows_)
            step_in_single(time_step, iterations);
        else
            step_in_double(time_step, iterations);
        if (ball_)
            ball_->end_step(time_step);
    }

    void set_state(const Field &positions, const Field &velocities) override {
        Simulation::set_state(positions, velocities);
        last_velocities_ = velocities;
        if (rows_) {
            put_into_rows(positions - rest_, rows_->row_of_node, rows_->displacement);
            put_into_rows(velocities, rows_->row_of_node, rows_->velocity);
            rows_->last_velocity = rows_->velocity;
        }
    }

    /// Accelerations that the next guess is made of stay those of steps.
    void kick(const Field &velocity, double time_step) override {
        const Field last = last_velocities_ + velocity;
        std::optional<kernels::Aligned<float>> last_rows;
        if (rows_)
            last_rows = rows_->last_velocity;
        Simulation::kick(velocity, time_step);
        last_velocities_ = last;
        for (Eigen::Index i = 0; rows_ && i < velocity.cols(); ++i) {
            const int row = rows_->row_of_node[i];
            in_row(rows_->last_velocity, row) = in_row(*last_rows, row) + velocity.col(i).cast<float>();
        }
    }

    void set_external_forces(const Field &forces) override {
        Simulation::set_external_forces(forces);
        if (rows_)
            put_into_rows(external_forces(), rows_->row_of_node, rows_->external);
    }

    const Energy &energy() const override { return energy_; }
    Orders orders() const override {
        Orders orders;
        orders.node_colour = node_colour_;
        if (rows_)
            orders.strips = rows_->strips;
        return orders;
    }
    Cost cost(int iterations) const override {
        return {.element_passes = 4.0 * iterations, // at each of its corners
                .bytes_per_element =
                    rows_ ? static_cast<double>(rows_->bytes()) / static_cast<double>(energy_.tetrahedra().size())
                          : static_cast<double>(sizeof(Tetrahedron) + 4 * sizeof(Corner))};
    }

  private:
    struct Corner {
        int tetrahedron;
        core::Vector3 slope; ///< b, the gradient of the shape function [1/m]
    };

    /// (N)
    std::vector<int> colours() const {
        if (scene().orders && !scene().orders->node_colour.empty())
            return scene().orders->node_colour;
        std::vector<std::vector<int>> sets;
        for (const auto &t : energy_.tetrahedra())
            sets.emplace_back(t.nodes.begin(), t.nodes.end());
        return colours_of(colour_nodes(sets, static_cast<int>(positions().cols())));
    }

    /// (N)
    std::vector<std::vector<int>> tetrahedra_around() const {
        std::vector<std::vector<int>> around(positions().cols());
        for (std::size_t t = 0; t < energy_.tetrahedra().size(); ++t)
            for (const int node : energy_.tetrahedra()[t].nodes)
                around[node].push_back(static_cast<int>(t));
        return around;
    }

    Corner corner_of(int tetrahedron, int node) const {
        const auto &t = energy_.tetrahedra()[tetrahedron];
        const auto corner = std::ranges::find(t.nodes, node) - t.nodes.begin();
        return {tetrahedron, t.shape_gradients().row(corner).transpose()};
    }

    void step_in_double(double time_step, int iterations) {
        auto &x = mutable_positions();
        auto &v = mutable_velocities();
        const Field before = x;
        const auto terms = inertia(*this, time_step);
        start(terms, time_step);
        auto pushed = terms;
        const double rho = chebyshev_rho(iterations);
        double weight = 1.0;
        Field older, oldest;
        for (int i = 1; i <= iterations; ++i) {
            weight = chebyshev_weight(i, weight, rho);
            oldest = std::move(older);
            older = x;
            for (std::size_t k = 0; k < nodes_.size(); ++k)
                descend(x, pushed, k);
            if (i > 1)
                x = weight * (x - oldest) + oldest;
            if (ball_)
                touch_in_double(before, terms, pushed);
        }
        last_velocities_ = v;
        v = (x - before) / time_step;
    }

    void step_in_single(double time_step, int iterations) {
        auto &x = mutable_positions();
        // Constrained nodes begin where they were told to be before, without what single precision has lost on the way.
        const auto &nodes = scene().constrained_nodes;
        for (std::size_t c = 0; c < nodes.size(); ++c) {
            const int row = rows_->row_of_node[nodes[c]];
            in_row(rows_->displacement, row) = (x.col(nodes[c]) - rest_.col(nodes[c])).cast<float>();
            in_row(rows_->predicted, row) =
                (targets().col(static_cast<Eigen::Index>(c)) - rest_.col(nodes[c])).cast<float>();
        }
        if (ball_) {
            terms_ = inertia(*this, time_step);
            before_ = x;
        }
        kernels::take_descent_step(*rows_, time_step, scene().mass_damping, iterations);
        take_from_rows(rows_->displacement, rows_->row_of_node, x);
        x += rest_;
        take_from_rows(rows_->velocity, rows_->row_of_node, mutable_velocities());
        move_to_targets(); // to the last bit
    }

    /// Where iterations begin: where the velocity goes, and the external acceleration as far as the last step followed
    /// it (section 3.7: less where a body rests).
    void start(const Inertia &terms, double time_step) {
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

    void add_node(int node, const std::vector<int> &around) {
        place_of_node_.resize(static_cast<std::size_t>(positions().cols()), 0);
        place_of_node_[node] = nodes_.size();
        nodes_.push_back(node);
        for (const int t : around)
            corners_.push_back(corner_of(t, node));
        offsets_.push_back(static_cast<int>(corners_.size()));
    }

    void descend(Field &x, const Inertia &terms, std::size_t k) const {
        const auto [gradient, hessian] = slope_of(x, terms, k);
        x.col(nodes_[k]) -= hessian.inverse() * gradient;
    }

    /// One sweep over the points that the ball is near to. Nodes give way as their own quadratic says.
    /// @param position  of a node: int -> something that can be added to
    /// @param inverse   of the Hessian of a node: int -> Matrix3
    template <class Position, class Inverse>
    void touch_nodes(const Field &before, const Position &position, const Inverse &inverse) {
        std::vector<std::optional<Matrix3>> found(static_cast<std::size_t>(positions().cols()));
        const auto yields = [&](int node) -> Matrix3 {
            if (!is_free()[node])
                return Matrix3::Zero();
            if (!found[node])
                found[node] = inverse(node);
            return *found[node];
        };
        const auto give = [&](int node, const core::Vector3 &force) {
            forces_[node] += force;
            position(node) += core::Vector3(yields(node) * force);
        };
        if (!has_touched_)
            ball_->begin_step(give);
        has_touched_ = true;
        ball_->sweep(
            ball_->part(0, 1), [&](int node) { return core::Vector3(before.col(node)); }, position, yields, give);
    }

    void touch_in_double(const Field &before, const Inertia &terms, Inertia &pushed) {
        auto &x = mutable_positions();
        touch_nodes(
            before, [&](int node) { return x.col(node); },
            [&](int node) { return Matrix3(slope_of(x, terms, place_of_node_[node]).hessian.inverse()); });
        for (const int node : ball_->near())
            if (is_free()[node])
                pushed.predicted.col(node) = with_force(terms, node);
    }

    /// Where inertia and the force of the ball lead a node, so that descent keeps it on the ball.
    core::Vector3 with_force(const Inertia &terms, int node) const {
        return terms.predicted.col(node) + forces_[node] / terms.stiffness[node];
    }

    /// The same with the nodes around a node as they are in rows.
    void touch_rows() {
        auto &x = mutable_positions();
        touch_nodes(
            before_,
            [&](int node) { return FineRow(rest_.col(node), in_row(rows_->displacement, rows_->row_of_node[node])); },
            [&](int node) {
                const std::size_t k = place_of_node_[node];
                for (int c = offsets_[k]; c < offsets_[k + 1]; ++c)
                    for (const int other : energy_.tetrahedra()[corners_[c].tetrahedron].nodes)
                        x.col(other) = position_in_row(other);
                return Matrix3(slope_of(x, terms_, k).hessian.inverse());
            });
        for (const int node : ball_->near())
            if (is_free()[node])
                in_row(rows_->predicted, rows_->row_of_node[node]) =
                    (with_force(terms_, node) - rest_.col(node)).cast<float>();
    }

    core::Vector3 position_in_row(int node) const {
        return rest_.col(node) + in_row(rows_->displacement, rows_->row_of_node[node]).cast<double>();
    }

    struct Slope {
        core::Vector3 gradient; ///< [N]
        Matrix3 hessian;        ///< [N/m]
    };

    /// Of the k-th of nodes_.
    Slope slope_of(const Field &x, const Inertia &terms, std::size_t k) const {
        const int node = nodes_[k];
        core::Vector3 gradient = terms.stiffness[node] * (x.col(node) - terms.predicted.col(node));
        Matrix3 hessian = terms.stiffness[node] * Matrix3::Identity();
        for (int c = offsets_[k]; c < offsets_[k + 1]; ++c) {
            const auto &[number, slope] = corners_[c];
            const auto &t = energy_.tetrahedra()[number];
            const Matrix3 f = t.gradient(x);
            const double volume_modulus = t.lambda + t.mu;
            const core::Vector3 turned = cofactors(f) * slope;
            gradient += t.volume * (t.mu * (f * slope) + (volume_modulus * (f.determinant() - 1.0) - t.mu) * turned);
            hessian += (t.volume * volume_modulus) * turned * turned.transpose();
            hessian.diagonal().array() += t.volume * t.mu * slope.squaredNorm();
        }
        return {gradient, hessian};
    }

    ElementEnergy<densities::StableNeoHookean> energy_;
    Field rest_;
    std::vector<int> node_colour_;             ///< (N)
    std::optional<kernels::DescentRows> rows_; ///< in single precision; what follows is of double precision
    std::vector<int> nodes_;                   ///< free ones, in the order of their colours; or those of a ball
    std::vector<std::size_t> place_of_node_;   ///< (N) in nodes_
    std::vector<int> offsets_;                 ///< into corners_, of each of nodes_, and the end
    std::vector<Corner> corners_;              ///< where a node is in its tetrahedra
    Field last_velocities_;                    ///< those before the last step
    std::shared_ptr<core::BallContact> ball_;  ///< and what a step needs of it
    std::vector<core::Vector3> forces_;        ///< (N) on the nodes, of the ball [N]
    bool has_touched_ = false;                 ///< in this step
    Inertia terms_;                            ///< in single precision
    Field before_;                             ///< the same
};

} // namespace

/// Block coordinate descent on the step of backward Euler, with the paper's acceleration and adaptive start, and
/// without its line search, which it leaves out where material is as soft as here.
Method vertex_block_descent() {
    return {.name = {},
            .summary = "vertex block descent on stable neo-Hookean tetrahedra, backward Euler",
            .source = "Chen, Liu, Yang, Yuksel 2024, Vertex block descent, ACM TOG 43(4); Wang 2015, "
                      "A Chebyshev semi-iterative approach, ACM TOG 34(6)",
            .energy = "mu / 2 (I1 - 3) - mu (J - 1) + (lambda + mu) / 2 (J - 1)^2",
            .converges_to = "the step of backward Euler",
            .objection =
                "It slows down where stiffness varies much (A. H. Chen 2026, A sparse coarse space for VBD, "
                "ankachan.github.io): 'livermark arena --mesh 1 --body liver_healthy liver_tumours --iterations 10 30 "
                "100 --method vertex_block_descent' shows it. Coordinate descent converges slowly beside Newton's "
                "method (Trusty 2025, arXiv:2510.12053), and a test of an engine accepts three times the displacement "
                "on another mesh (newton-physics/newton#2901): --mesh 1 2 in the same command. Chebyshev's weights, "
                "which are used here, were unstable and difficult to tune for an author of its successor (C. Giles, "
                "quoted in MysteryPancake/Houdini-VBD, README.md).",
            .implementation = "vector units over nodes of one colour, single precision",
            .in_double = "plain loop over nodes in the order of colours, F anew at each corner, double",
            .time_step = frame_time,
            .iterations = 20,
            .knows_contact = true,
            .prepare = [](const Scene &scene) { return std::make_unique<VertexBlockDescent>(scene); }};
}

} // namespace livermark::interactive::methods
