#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "interactive/colouring.hpp"
#include "interactive/kernels/position_rows.hpp"
#include "interactive/scene.hpp"

namespace livermark::interactive {

/// Constraints of one kind with their compliances and multipliers, in the order of their colours. A kind has
///     static constexpr int num_nodes, num_constraints;    n and K: K constraints on n nodes are solved together
///     std::array<int, n> nodes;
///     Vector compliance;                                  alpha, so that the energy is C^2 / (2 alpha)
///     void evaluate(const Field &x, Vector &c, Gradients &g) const;    C and dC/dx
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
        : colours_(std::move(colours)), multipliers_(kinds.size()) {
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
        clear();
    }

    /// (M) in the order in which constraints were given
    const std::vector<int> &colours() const { return colours_; }

    /// All multipliers to zero, as a step begins.
    void clear() {
        for (auto &multiplier : multipliers_)
            multiplier.setZero();
    }

    /// One iteration.
    /// @param inverse_mass  (N) [1/kg], zero where a node does not move
    void project(Field &x, const std::vector<double> &inverse_mass, double time_step) {
        Vector c;
        Gradients g, weighted;
        for (std::size_t k = 0; k < kinds_.size(); ++k) {
            const auto &kind = kinds_[k];
            kind.evaluate(x, c, g);
            for (int a = 0; a < num_nodes; ++a)
                weighted.template middleRows<3>(3 * a) = inverse_mass[kind.nodes[a]] * g.template middleRows<3>(3 * a);
            const Vector compliance = kind.compliance / (time_step * time_step);
            Eigen::Matrix<double, num_constraints, num_constraints> matrix = g.transpose() * weighted;
            matrix.diagonal() += compliance;
            const Vector change = matrix.inverse() * (-c - compliance.cwiseProduct(multipliers_[k]));
            multipliers_[k] += change;
            const Eigen::Matrix<double, 3 * num_nodes, 1> move = weighted * change;
            for (int a = 0; a < num_nodes; ++a)
                x.col(kind.nodes[a]) += move.template segment<3>(3 * a);
        }
    }

    /// f += g lambda / h^2 [N], what the constraints pull with.
    /// @param rows  whose multipliers these are, of rows(); its own if there are none
    void add_forces(const Field &x, double time_step, Field &f, const kernels::ConstraintRows *rows = nullptr) const {
        Vector c;
        Gradients g;
        for (std::size_t k = 0; k < kinds_.size(); ++k) {
            kinds_[k].evaluate(x, c, g);
            const Vector multipliers = rows == nullptr ? multipliers_[k] : multipliers_in(*rows, k);
            const Eigen::Matrix<double, 3 * num_nodes, 1> force = g * multipliers / (time_step * time_step);
            for (int a = 0; a < num_nodes; ++a)
                f.col(kinds_[k].nodes[a]) += force.template segment<3>(3 * a);
        }
    }

    /// The largest |C + alpha~ lambda| over |C|: zero once iterations have converged.
    double residual(const Field &x, double time_step) const {
        double left = 0.0, size = 0.0;
        Vector c;
        Gradients g;
        for (std::size_t k = 0; k < kinds_.size(); ++k) {
            kinds_[k].evaluate(x, c, g);
            left = std::max(left, (c + kinds_[k].compliance.cwiseProduct(multipliers_[k]) / (time_step * time_step))
                                      .cwiseAbs()
                                      .maxCoeff());
            size = std::max(size, c.cwiseAbs().maxCoeff());
        }
        return size == 0.0 ? 0.0 : left / size;
    }

    /// The same constraints for vectors, in the same order of colours. A kind has
    ///     static constexpr kernels::Constraint constraint;    what the vectors call it
    ///     std::array<double, num_numbers_of(constraint)> numbers(const Field &rest) const;
    kernels::ConstraintRows rows(const Field &rest) const {
        std::vector<int> nodes;
        std::vector<double> numbers;
        nodes.reserve(kinds_.size() * num_nodes);
        numbers.reserve(kinds_.size() * kernels::num_numbers_of(Kind::constraint));
        for (const auto &kind : kinds_) {
            nodes.insert(nodes.end(), kind.nodes.begin(), kind.nodes.end());
            const auto of_kind = kind.numbers(rest);
            numbers.insert(numbers.end(), of_kind.begin(), of_kind.end());
        }
        return kernels::constraint_rows(Kind::constraint, offsets_, nodes, numbers, static_cast<int>(rest.cols()));
    }

    std::size_t bytes() const { return kinds_.size() * (sizeof(Kind) + sizeof(Vector)); }

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
    std::vector<Vector> multipliers_;
};

} // namespace livermark::interactive
