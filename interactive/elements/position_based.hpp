#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "interactive/elements/energies.hpp"
#include "interactive/elements/point_springs.hpp"
#include "interactive/kernels/method_steps.hpp"
#include "interactive/kernels/orders.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive {

/// Steps of extended position-based dynamics: nodes go to where they would without elasticity, iterations over all
/// constraints move them from there, and velocities follow from positions. A method says what its constraints are. A
/// ball that touches is a constraint at each point of the facets that it is near to, after all others in each
/// iteration: see core::BallContact.
class PositionBased : public SimulationInRows {
  public:
    explicit PositionBased(Scene given);

    void step(double time_step, int iterations) override;
    void set_state(const Field &positions, const Field &velocities) override;
    void kick(const Field &velocity, double time_step) override;
    bool touch(const std::shared_ptr<core::BallContact> &ball) override;

    /// Forces of the multipliers, as far as iterations have come: what a program would send to a haptic device.
    /// Before the first step those of the energy.
    Field elastic_forces() const override;

    Cost cost(int iterations) const override { return cost_of(iterations, rows_.bytes()); }

  protected:
    /// @param sets  with their multipliers, in the order of use_constraints()
    virtual void add_constraint_forces(const Field &x, double time_step, std::span<const kernels::ConstraintRows> sets,
                                       Field &f) const = 0;
    /// Steps go over these from now on.
    void use_constraints(std::vector<kernels::ConstraintRows> sets) { rows_.sets = std::move(sets); }

  private:
    kernels::NodeRows &rows() override { return rows_; }
    /// One iteration; the first one of a step begins with the forces of the step before.
    void project_ball();

    double time_step_ = 0.0;               ///< that is being taken [s]
    bool has_touched_ = false;             ///< in this step
    std::optional<double> last_time_step_; ///< [s]
    kernels::PositionRows rows_;
};

/// C = |x_a - x_b| - l, alpha = 1 / k.
struct Distance {
    static constexpr int num_nodes = 2, num_constraints = 1;
    static constexpr auto constraint = kernels::Constraint::distance;
    std::array<int, 2> nodes;
    Eigen::Matrix<double, 1, 1> compliance; ///< [m/N]
    double rest_length;

    void evaluate(const Field &x, Eigen::Matrix<double, 1, 1> &c, Eigen::Matrix<double, 6, 1> &g) const {
        const core::Vector3 d = x.col(nodes[0]) - x.col(nodes[1]);
        const double length = d.norm();
        c[0] = length - rest_length;
        g << d / length, -d / length;
    }

    std::array<double, 5> numbers(const Field &rest) const {
        const core::Vector3 d = rest.col(nodes[0]) - rest.col(nodes[1]);
        return {d.x(), d.y(), d.z(), rest_length, compliance[0]};
    }
};

/// C = |d| - l of a PointSpring of four nodes, alpha = 1 / k.
struct Fibre {
    static constexpr int num_nodes = 4, num_constraints = 1;
    static constexpr auto constraint = kernels::Constraint::fibre;
    std::array<int, 4> nodes;
    Eigen::Matrix<double, 1, 1> compliance; ///< [m/N]
    Eigen::Vector4d weights;
    double rest_length;

    core::Vector3 span(const Field &x) const {
        core::Vector3 sum = core::Vector3::Zero();
        for (int a = 0; a < num_nodes; ++a)
            sum += weights[a] * x.col(nodes[a]);
        return sum;
    }

    void evaluate(const Field &x, Eigen::Matrix<double, 1, 1> &c, Eigen::Matrix<double, 12, 1> &g) const {
        const core::Vector3 d = span(x);
        const double length = d.norm();
        c[0] = length - rest_length;
        for (int a = 0; a < num_nodes; ++a)
            g.segment<3>(3 * a) = weights[a] / length * d;
    }

    std::array<double, 9> numbers(const Field &rest) const {
        const core::Vector3 d = span(rest);
        return {weights[0], weights[1], weights[2], weights[3], d.x(), d.y(), d.z(), rest_length, compliance[0]};
    }
};

/// C = J - 1, alpha = 1 / (V k) with k of VolumeBesideSprings.
struct Volume {
    static constexpr int num_nodes = 4, num_constraints = 1;
    static constexpr auto constraint = kernels::Constraint::volume;
    std::array<int, 4> nodes;
    Eigen::Matrix<double, 1, 1> compliance; ///< [1/J]
    double rest_six_volumes;

    void evaluate(const Field &x, Eigen::Matrix<double, 1, 1> &c, Eigen::Matrix<double, 12, 1> &g) const {
        Matrix3 edges;
        for (int e = 0; e < 3; ++e)
            edges.col(e) = x.col(nodes[e + 1]) - x.col(nodes[0]);
        const Matrix3 slopes = cofactors(edges) / rest_six_volumes;
        c[0] = edges.determinant() / rest_six_volumes - 1.0;
        g << -slopes.rowwise().sum(), slopes.col(0), slopes.col(1), slopes.col(2);
    }

    std::array<double, 10> numbers(const Field &rest) const {
        Matrix3 edges;
        for (int e = 0; e < 3; ++e)
            edges.row(e) = rest.col(nodes[e + 1]) - rest.col(nodes[0]);
        const Matrix3 gradients = edges.inverse(); // by columns
        std::array<double, 10> numbers{};
        *std::copy_n(gradients.data(), gradients.size(), numbers.begin()) = compliance[0];
        return numbers;
    }
};

/// Two constraints of a tetrahedron: C_D = |F|, alpha_D = 1 / (mu V), and C_H = J - 1 - mu / k, alpha_H = 1 / (k V)
/// with k = lambda + mu. Solved together they leave a body at rest in its shape; one after the other they do not before
/// they have converged.
struct NeoHookeanPair {
    static constexpr int num_nodes = 4, num_constraints = 2;
    static constexpr auto constraint = kernels::Constraint::pair;
    std::array<int, 4> nodes;
    Eigen::Vector2d compliance; ///< [1/J]
    Matrix3 inverse_edges;
    double rest; ///< 1 + mu / k

    void evaluate(const Field &x, Eigen::Vector2d &c, Eigen::Matrix<double, 12, 2> &g) const {
        Matrix3 edges;
        for (int e = 0; e < 3; ++e)
            edges.col(e) = x.col(nodes[e + 1]) - x.col(nodes[0]);
        const Matrix3 f = edges * inverse_edges;
        const double size = f.norm();
        c << size, f.determinant() - rest;
        const Matrix3 deviatoric = f / size * inverse_edges.transpose();
        const Matrix3 hydrostatic = cofactors(f) * inverse_edges.transpose();
        g.col(0) << -deviatoric.rowwise().sum(), deviatoric.col(0), deviatoric.col(1), deviatoric.col(2);
        g.col(1) << -hydrostatic.rowwise().sum(), hydrostatic.col(0), hydrostatic.col(1), hydrostatic.col(2);
    }

    std::array<double, 12> numbers(const Field & /*rest*/) const {
        const Matrix3 gradients = inverse_edges.transpose(); // by columns
        std::array<double, 12> numbers{};
        *std::copy_n(gradients.data(), gradients.size(), numbers.begin()) = rest - 1.0;
        numbers[10] = compliance[0];
        numbers[11] = compliance[1];
        return numbers;
    }
};

inline std::vector<Distance> distances(const Springs &springs) {
    std::vector<Distance> result;
    result.reserve(springs.edges.size());
    for (std::size_t s = 0; s < springs.edges.size(); ++s)
        result.push_back({.nodes = springs.edges[s],
                          .compliance = Eigen::Matrix<double, 1, 1>(1.0 / springs.stiffness[s]),
                          .rest_length = springs.rest_length[s]});
    return result;
}

/// Constraints of springs of two nodes.
inline std::vector<Distance> distances(std::span<const PointSpring> springs) {
    std::vector<Distance> result;
    for (const auto &spring : springs)
        if (spring.nodes.size() == 2)
            result.push_back({.nodes = {spring.nodes[0], spring.nodes[1]},
                              .compliance = Eigen::Matrix<double, 1, 1>(1.0 / spring.stiffness),
                              .rest_length = spring.rest_length});
    return result;
}

/// Constraints of springs of four nodes.
inline std::vector<Fibre> fibres(std::span<const PointSpring> springs) {
    std::vector<Fibre> result;
    for (const auto &spring : springs)
        if (spring.nodes.size() == 4)
            result.push_back({.nodes = {spring.nodes[0], spring.nodes[1], spring.nodes[2], spring.nodes[3]},
                              .compliance = Eigen::Matrix<double, 1, 1>(1.0 / spring.stiffness),
                              .weights = Eigen::Vector4d::Map(spring.weights.data()),
                              .rest_length = spring.rest_length});
    return result;
}

/// Whether springs lack volume stiffness of the material.
inline bool has_volume(const Tetrahedron &t) {
    return densities::VolumeBesideSprings{t.mu, t.lambda}.modulus() > 0.0;
}

/// One for each tetrahedron that has_volume().
inline std::vector<Volume> volumes(std::span<const Tetrahedron> tetrahedra) {
    std::vector<Volume> result;
    result.reserve(tetrahedra.size());
    for (const auto &t : tetrahedra)
        if (has_volume(t)) {
            const double modulus = densities::VolumeBesideSprings{t.mu, t.lambda}.modulus();
            result.push_back({.nodes = t.nodes,
                              .compliance = Eigen::Matrix<double, 1, 1>(1.0 / (t.volume * modulus)),
                              .rest_six_volumes = 6.0 * t.volume});
        }
    return result;
}

inline std::vector<NeoHookeanPair> neo_hookean_pairs(std::span<const Tetrahedron> tetrahedra) {
    std::vector<NeoHookeanPair> result;
    result.reserve(tetrahedra.size());
    for (const auto &t : tetrahedra) {
        const double k = t.lambda + t.mu;
        result.push_back({.nodes = t.nodes,
                          .compliance = {1.0 / (t.mu * t.volume), 1.0 / (k * t.volume)},
                          .inverse_edges = t.inverse_edges,
                          .rest = 1.0 + t.mu / k});
    }
    return result;
}

/// Constraints of one kind with their compliances, in the order of their colours. A kind has
///     static constexpr int num_nodes, num_constraints;    n and K: K constraints on n nodes are solved together
///     static constexpr kernels::Constraint constraint;    what the vectors call it
///     std::array<int, n> nodes;
///     Vector compliance;                                  alpha, so that the energy is C^2 / (2 alpha)
///     void evaluate(const Field &x, Vector &c, Gradients &g) const;    C and dC/dx
///     std::array<double, num_numbers_of(constraint)> numbers(const Field &rest) const;
/// with Vector of size K and Gradients of shape (3 n, K).
///
/// One iteration visits each once: with alpha~ = alpha / h^2 and W the inverse masses at its nodes,
///     (g^T W g + alpha~) dlambda = -C - alpha~ lambda,   lambda += dlambda,   x += W g dlambda.
/// (Macklin, Mueller, Chentanez 2016, XPBD: position-based simulation of compliant constrained dynamics, MIG, eq. 17,
/// 18)
template <class Kind> class ConstraintSet {
  public:
    static constexpr int num_constraints = Kind::num_constraints, num_nodes = Kind::num_nodes;
    using Vector = Eigen::Matrix<double, num_constraints, 1>;
    using Gradients = Eigen::Matrix<double, 3 * num_nodes, num_constraints>;

    /// @param colours  (M) that they have already, so that no two of a colour share a node; empty to find some
    ConstraintSet(const std::vector<Kind> &kinds, int num_nodes_of_mesh, std::vector<int> colours = {})
        : colours_(std::move(colours)) {
        if (colours_.empty()) {
            std::vector<std::vector<int>> sets;
            for (const auto &kind : kinds)
                sets.emplace_back(kind.nodes.begin(), kind.nodes.end());
            colours_ = colours_of(colour_sets(sets, num_nodes_of_mesh));
        }
        auto colouring = by_colours(colours_);
        kinds_.reserve(kinds.size());
        for (const int k : colouring.order)
            kinds_.push_back(kinds[k]);
        offsets_ = std::move(colouring.offsets);
    }

    /// (M) in the order in which constraints were given
    const std::vector<int> &colours() const { return colours_; }

    /// f += g lambda / h^2 [N], what the constraints pull with.
    /// @param rows  of rows(), with the multipliers
    void add_forces(const Field &x, double time_step, const kernels::ConstraintRows &rows, Field &f) const {
        Vector c;
        Gradients g;
        for (std::size_t k = 0; k < kinds_.size(); ++k) {
            kinds_[k].evaluate(x, c, g);
            const Eigen::Matrix<double, 3 * num_nodes, 1> force = g * multipliers_in(rows, k) / (time_step * time_step);
            for (int a = 0; a < num_nodes; ++a)
                f.col(kinds_[k].nodes[a]) += force.template segment<3>(3 * a);
        }
    }

    /// The same constraints for vectors, in the same order of colours.
    kernels::ConstraintRows rows(const Field &rest) const {
        std::vector<int> nodes;
        std::vector<double> numbers;
        nodes.reserve(kinds_.size() * num_nodes);
        numbers.reserve(kinds_.size() * kernels::num_numbers_of(Kind::constraint));
        for (const auto &kind : kinds_) {
            nodes.insert(nodes.end(), kind.nodes.begin(), kind.nodes.end());
            const auto own = kind.numbers(rest);
            numbers.insert(numbers.end(), own.begin(), own.end());
        }
        return kernels::constraint_rows(Kind::constraint, offsets_, nodes, numbers, static_cast<int>(rest.cols()));
    }

  private:
    static Vector multipliers_in(const kernels::ConstraintRows &rows, std::size_t k) {
        const std::size_t batch = rows.place[k] / kernels::slice_size, lane = rows.place[k] % kernels::slice_size;
        Vector multipliers;
        for (int c = 0; c < num_constraints; ++c)
            multipliers[c] = rows.multipliers[(batch * num_constraints + c) * kernels::slice_size + lane];
        return multipliers;
    }

    std::vector<int> colours_; ///< in the order of the constructor
    std::vector<Kind> kinds_;
    std::vector<int> offsets_; ///< of colours, and the end
};

} // namespace livermark::interactive
