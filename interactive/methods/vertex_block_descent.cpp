#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "interactive/colouring.hpp"
#include "interactive/elements/element_energy.hpp"
#include "interactive/inertia.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

namespace {

/// Backward Euler by descent on one node at a time: an iteration visits the nodes in the order of their colours, and
/// moves each by -H^-1 g of its own three unknowns, with the nodes around it where they are. W is quadratic along F and
/// J is linear in each node, so H = k + sum of V (mu |b|^2 + (lambda + mu) (c b) (c b)^T), with b the gradient of the
/// shape function and c the cofactors of F, is positive definite.
class VertexBlockDescent : public Simulation {
  public:
    explicit VertexBlockDescent(Scene given)
        : Simulation(std::move(given)), energy_(tetrahedra_at_rest(*scene().body)), offsets_{0},
          last_velocities_(velocities()) {
        std::vector<std::vector<int>> sets, around(positions().cols());
        for (std::size_t t = 0; t < energy_.tetrahedra().size(); ++t) {
            const auto &nodes = energy_.tetrahedra()[t].nodes;
            sets.emplace_back(nodes.begin(), nodes.end());
            for (const int node : nodes)
                around[node].push_back(static_cast<int>(t));
        }
        for (const int node : colour_nodes(sets, static_cast<int>(positions().cols())).order) {
            if (!is_free()[node])
                continue;
            nodes_.push_back(node);
            for (const int t : around[node])
                corners_.push_back(corner_of(t, node));
            offsets_.push_back(static_cast<int>(corners_.size()));
        }
    }

    void step(double time_step, int iterations) override {
        auto &x = mutable_positions();
        auto &v = mutable_velocities();
        const Field before = x;
        const auto terms = inertia(*this, time_step);
        start(terms, time_step);
        for (int i = 0; i < iterations; ++i)
            for (std::size_t k = 0; k < nodes_.size(); ++k)
                descend(x, terms, k);
        last_velocities_ = v;
        v = (x - before) / time_step;
    }

    void set_state(const Field &positions, const Field &velocities) override {
        Simulation::set_state(positions, velocities);
        last_velocities_ = velocities;
    }

    const Energy &energy() const override { return energy_; }
    Cost cost(int iterations) const override {
        return {.element_passes = 4.0 * iterations, // at each of its corners
                .bytes_per_element = static_cast<double>(sizeof(Tetrahedron) + 4 * sizeof(Corner))};
    }

  private:
    struct Corner {
        int tetrahedron;
        core::Vector3 slope; ///< b, the gradient of the shape function [1/m]
    };

    Corner corner_of(int tetrahedron, int node) const {
        const auto &t = energy_.tetrahedra()[tetrahedron];
        const auto corner = std::ranges::find(t.nodes, node) - t.nodes.begin();
        return {tetrahedron, t.shape_gradients().row(corner).transpose()};
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

    void descend(Field &x, const Inertia &terms, std::size_t k) const {
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
        x.col(node) -= hessian.inverse() * gradient;
    }

    ElementEnergy<densities::StableNeoHookean> energy_;
    std::vector<int> nodes_;      ///< free ones, in the order of their colours
    std::vector<int> offsets_;    ///< into corners_, of each of nodes_, and the end
    std::vector<Corner> corners_; ///< where a node is in its tetrahedra
    Field last_velocities_;       ///< those before the last step
};

} // namespace

/// Block coordinate descent on the step of backward Euler. Without the paper's acceleration and line search, which it
/// leaves out where material is as soft as here.
Method vertex_block_descent() {
    return {.name = {},
            .summary = "vertex block descent on stable neo-Hookean tetrahedra, backward Euler",
            .source = "Chen, Liu, Yang, Yuksel 2024, Vertex block descent, ACM TOG 43(4)",
            .energy = "mu / 2 (I1 - 3) - mu (J - 1) + (lambda + mu) / 2 (J - 1)^2",
            .converges_to = "the step of backward Euler",
            .implementation = "plain loop over nodes in the order of colours, F anew at each corner, double",
            .time_step = frame_time,
            .iterations = 20,
            .prepare = [](const Scene &scene) { return std::make_unique<VertexBlockDescent>(scene); }};
}

} // namespace livermark::interactive::methods
