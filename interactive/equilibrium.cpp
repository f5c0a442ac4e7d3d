#include "interactive/equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "core/support/factors/sparse_cholesky.hpp"
#include "interactive/elements/point_springs.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive {

namespace {

using Sparse = Eigen::SparseMatrix<double>;

class Newton {
  public:
    Newton(const Energy &energy, const std::vector<bool> &is_free, const Field &forces, const Inertia *inertia,
           Loads loads = Loads::known)
        : energy_(energy), forces_(forces), inertia_(inertia), presses_(loads == Loads::press),
          unknown_(3 * is_free.size(), -1) {
        for (std::size_t i = 0; i < is_free.size(); ++i)
            for (std::size_t c = 0; c < 3; ++c)
                if (is_free[i])
                    unknown_[3 * i + c] = num_unknowns_++;
        unit_load_ = unknowns_in(forces);
    }

    Minimum minimise(Field x, const NewtonSettings &settings) {
        Minimum minimum{std::move(x)};
        while (true) {
            double size = 0.0;
            const Eigen::VectorXd gradient = gradient_at(minimum.positions, size);
            minimum.press = amount_;
            const auto is_balanced = [&] {
                minimum.residual = gradient.norm() == 0.0 ? 0.0 : gradient.norm() / std::max(size, smallest_size_);
                return minimum.converged = minimum.residual <= settings.tolerance;
            };
            if (is_balanced() || minimum.iterations == settings.max_iterations || !std::isfinite(minimum.residual))
                return minimum;
            const Eigen::VectorXd direction = descent(minimum.positions, gradient);
            if (is_balanced()) // now that the stiffness is known
                return minimum;
            ++minimum.iterations;
            if (direction.size() == 0 || !advance(minimum.positions, direction, gradient))
                return minimum;
        }
    }

    /// Positions to which the free nodes go by the tangent at x when the forces are added and constrained nodes move.
    Field predict(const Field &x, const Field &moved_to) {
        Energy::Triplets all;
        energy_.add_hessian(x, true, all);
        const Field by = moved_to - x; // zero at free nodes
        Eigen::VectorXd right = unit_load_;
        for (const auto &entry : all)
            if (unknown_[entry.row()] >= 0 && unknown_[entry.col()] < 0)
                right[unknown_[entry.row()]] -= entry.value() * by.data()[entry.col()];
        const Sparse matrix = upper_of_free(all);
        factor_.order(matrix);
        is_ordered_ = true;
        return factor_.factorise(matrix) ? moved(moved_to, factor_.solve(right)) : moved_to;
    }

  private:
    Eigen::VectorXd unknowns_in(const Field &field) const {
        Eigen::VectorXd result(num_unknowns_);
        for (std::size_t k = 0; k < unknown_.size(); ++k)
            if (unknown_[k] >= 0)
                result[unknown_[k]] = field.data()[k];
        return result;
    }

    /// Work of known forces at positions [J].
    double work(const Field &x) const { return presses_ ? 0.0 : forces_.cwiseProduct(x).sum(); }

    double value(const Field &x) const {
        double value = energy_.value(x) - work(x);
        if (inertia_)
            for (Eigen::Index i = 0; i < x.cols(); ++i)
                value += 0.5 * inertia_->stiffness[i] * (x.col(i) - inertia_->predicted.col(i)).squaredNorm();
        return value;
    }

    /// Gradient by the unknowns. The size is that of the forces which are in balance: the elastic ones of all nodes.
    Eigen::VectorXd gradient_at(const Field &x, double &size) {
        Field f = Field::Zero(3, x.cols());
        energy_.add_forces(x, f);
        if (presses_) // as much as leaves least
            amount_ = -unknowns_in(f).dot(unit_load_) / unit_load_.squaredNorm();
        size = std::max(f.norm(), std::abs(amount_) * forces_.norm());
        f += amount_ * forces_;
        if (inertia_)
            for (Eigen::Index i = 0; i < x.cols(); ++i) {
                const core::Vector3 pull = inertia_->stiffness[i] * (inertia_->predicted.col(i) - x.col(i));
                f.col(i) += pull;
                size = std::max(size, pull.norm());
            }
        return -unknowns_in(f);
    }

    Sparse hessian(const Field &x, bool is_projected) const {
        Energy::Triplets all;
        energy_.add_hessian(x, is_projected, all);
        return upper_of_free(all);
    }

    /// The upper triangle, all that factors look at.
    Sparse upper_of_free(const Energy::Triplets &all) const {
        Energy::Triplets kept;
        kept.reserve(all.size() / 2);
        for (const auto &entry : all) {
            const int row = unknown_[entry.row()];
            const int column = unknown_[entry.col()];
            if (row >= 0 && column >= row)
                kept.emplace_back(row, column, entry.value());
        }
        for (std::size_t k = 0; k < unknown_.size(); ++k)
            if (unknown_[k] >= 0) // an entry also where it is zero, so that the places are the same each time
                kept.emplace_back(unknown_[k], unknown_[k], inertia_ ? inertia_->stiffness[k / 3] : 0.0);
        Sparse matrix(num_unknowns_, num_unknowns_);
        matrix.setFromTriplets(kept.begin(), kept.end());
        return matrix;
    }

    /// Empty if there is none.
    Eigen::VectorXd descent(const Field &x, const Eigen::VectorXd &gradient) {
        for (const bool is_projected : {false, true}) {
            const Sparse matrix = hessian(x, is_projected);
            if (!is_ordered_)
                factor_.order(matrix);
            is_ordered_ = true;
            if (smallest_size_ == 0.0) {
                const core::Vector3 extent = x.rowwise().maxCoeff() - x.rowwise().minCoeff();
                smallest_size_ = noticed * matrix.diagonal().cwiseAbs().maxCoeff() * extent.norm();
            }
            if (!factor_.factorise(matrix))
                continue;
            Eigen::VectorXd direction = -factor_.solve(gradient);
            if (presses_) { // without what changes f . x
                const Eigen::VectorXd along = factor_.solve(unit_load_);
                direction -= unit_load_.dot(direction) / unit_load_.dot(along) * along;
            }
            if (direction.dot(gradient) < 0.0)
                return direction;
        }
        return {};
    }

    /// Armijo's rule, or a smaller gradient where rounding hides what the value loses.
    bool advance(Field &x, const Eigen::VectorXd &direction, const Eigen::VectorXd &gradient) {
        constexpr double decrease = 1e-4, rounding = 1e-13, shortest = 1e-12;
        const double start = value(x);
        const double noise = rounding * (std::abs(start) + (presses_ ? 0.0 : forces_.cwiseProduct(x).cwiseAbs().sum()));
        const double slope = direction.dot(gradient);
        for (double length = 1.0; length > shortest; length *= 0.5) {
            const Field tried = moved(x, length * direction);
            const double end = value(tried);
            double unused = 0.0;
            if (std::isfinite(end) &&
                (end <= start + decrease * length * slope ||
                 (std::abs(end - start) <= noise && gradient_at(tried, unused).norm() < gradient.norm()))) {
                x = tried;
                return true;
            }
        }
        return false;
    }

    Field moved(Field x, const Eigen::VectorXd &by) const {
        for (std::size_t k = 0; k < unknown_.size(); ++k)
            if (unknown_[k] >= 0)
                x.data()[k] += by[unknown_[k]];
        return x;
    }

    const Energy &energy_;
    const Field &forces_;
    const Inertia *inertia_;
    bool presses_;
    double amount_ = 1.0;       ///< what forces are multiplied by
    std::vector<int> unknown_;  ///< (3 N), -1 where constrained
    Eigen::VectorXd unit_load_; ///< the forces on them
    int num_unknowns_ = 0;
    bool is_ordered_ = false;
    /// Forces that move nodes by a millionth of the body are not balanced better than rounding allows.
    static constexpr double noticed = 1e-6;
    double smallest_size_ = 0.0; ///< [N], zero as long as no stiffness is known
    support::SparseCholesky factor_;
};

} // namespace

Minimum minimise(const Energy &energy, const std::vector<bool> &is_free, const Field &forces, const Inertia *inertia,
                 const Field &start, const NewtonSettings &settings) {
    return Newton(energy, is_free, forces, inertia, settings.loads).minimise(start, settings);
}

Field predict(const Energy &energy, const std::vector<bool> &is_free, const Field &x, const Field &moved_to,
              const Field &more_forces) {
    return Newton(energy, is_free, more_forces, nullptr).predict(x, moved_to);
}

namespace {

/// From where the body is to the next fraction, in as many steps as it takes.
void advance(Equilibrium &state, double to, const Simulation &simulation, const Energy &energy, double tolerance,
             double press_depth) {
    const auto &scene = simulation.scene();
    const auto &external_forces = simulation.external_forces();
    const auto &targets = simulation.targets();
    constexpr double shortest = 1.0 / 256.0;
    constexpr int max_iterations = 40;
    const auto is_free = free_nodes(scene);
    const Field rest = rest_positions(scene);
    Field rest_targets(3, targets.cols());
    for (Eigen::Index c = 0; c < targets.cols(); ++c)
        rest_targets.col(c) = rest.col(scene.constrained_nodes[c]);
    const double begin = state.fraction;
    double length = to - begin;
    state.converged = false;
    while (state.fraction < to) {
        const double next = state.fraction + length > to - 1e-9 ? to : state.fraction + length;
        Field moved = state.positions;
        put_constrained(scene, rest_targets + next * (targets - rest_targets), moved);
        const bool presses = press_depth != 0.0;
        Field start = predict(energy, is_free, state.positions, moved,
                              presses ? external_forces : Field((next - state.fraction) * external_forces));
        if (presses) {
            const auto depth_of = [&](const Field &by) { return external_forces.cwiseProduct(by).sum(); };
            const double missing = next * press_depth - depth_of(state.positions - rest);
            const Field by_one_newton = start - state.positions;
            start = state.positions + missing / depth_of(by_one_newton) * by_one_newton;
        }
        auto minimum = minimise(
            energy, is_free, presses ? external_forces : Field(next * external_forces), nullptr, start,
            {.tolerance = tolerance, .max_iterations = max_iterations, .loads = presses ? Loads::press : Loads::known});
        state.iterations += minimum.iterations;
        if (minimum.converged) {
            state.fraction = next;
            state.load = presses ? minimum.press : next;
            state.positions = std::move(minimum.positions);
        } else if ((length *= 0.5) < shortest * (to - begin)) {
            break;
        }
    }
    state.converged = state.fraction == to;
    state.elastic_forces.setZero();
    energy.add_forces(state.positions, state.elastic_forces);
}

} // namespace

std::vector<Equilibrium> equilibria(const Simulation &simulation, const std::vector<double> &fractions,
                                    double tolerance, double press_depth, const core::Foundation *foundation) {
    const Field rest = rest_positions(simulation.scene());
    std::optional<OnFoundation> on_foundation;
    if (foundation)
        on_foundation.emplace(simulation.energy(), simulation.scene(), *foundation);
    const Energy &energy = on_foundation ? *on_foundation : simulation.energy();
    Equilibrium state{.positions = rest, .elastic_forces = Field::Zero(3, rest.cols())};
    std::vector<Equilibrium> result;
    for (const double fraction : fractions) {
        advance(state, fraction, simulation, energy, tolerance, press_depth);
        result.push_back(state);
        if (!state.converged)
            break;
    }
    return result;
}

namespace {

/// The upper triangle of h^2 K + M (1 + alpha h), of unknowns.
/// @param unknown  (3 N) number of each, -1 where constrained
Eigen::SparseMatrix<double> step_matrix(const Simulation &at_rest, double time_step, const std::vector<int> &unknown,
                                        int num_unknowns) {
    const double square = time_step * time_step;
    Energy::Triplets all, kept;
    at_rest.energy().add_hessian(rest_positions(at_rest.scene()), false, all);
    for (const auto &entry : all) {
        const int row = unknown[entry.row()], column = unknown[entry.col()];
        if (row >= 0 && column >= row)
            kept.emplace_back(row, column, square * entry.value());
    }
    const auto terms = inertia(at_rest, time_step);
    for (std::size_t k = 0; k < unknown.size(); ++k)
        if (unknown[k] >= 0)
            kept.emplace_back(unknown[k], unknown[k], square * terms.stiffness[k / 3]);
    Eigen::SparseMatrix<double> matrix(num_unknowns, num_unknowns);
    matrix.setFromTriplets(kept.begin(), kept.end());
    return matrix;
}

} // namespace

Eigen::MatrixXf place_response(const Simulation &at_rest, double time_step,
                               const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights) {
    const auto is_free = free_nodes(at_rest.scene());
    std::vector<int> unknown(3 * is_free.size(), -1);
    int num_unknowns = 0;
    for (std::size_t k = 0; k < unknown.size(); ++k)
        if (is_free[k / 3])
            unknown[k] = num_unknowns++;
    Eigen::MatrixXf response = Eigen::MatrixXf::Zero(static_cast<Eigen::Index>(unknown.size()), 3 * weights.rows());
    if (num_unknowns == 0)
        return response;
    const auto matrix = step_matrix(at_rest, time_step, unknown, num_unknowns);
    support::SparseCholesky factor;
    factor.order(matrix);
    if (!factor.factorise(matrix))
        throw std::logic_error("the matrix of a step is not positive definite at rest");
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(num_unknowns, response.cols());
    for (Eigen::Index place = 0; place < weights.rows(); ++place)
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(weights, place); entry; ++entry)
            for (Eigen::Index c = 0; c < 3; ++c)
                if (const int row = unknown[3 * entry.col() + c]; row >= 0)
                    right(row, 3 * place + c) = entry.value();
    const Eigen::MatrixXd solution = factor.solve(right);
    for (std::size_t k = 0; k < unknown.size(); ++k)
        if (unknown[k] >= 0)
            response.row(static_cast<Eigen::Index>(k)) = solution.row(unknown[k]).cast<float>();
    return response;
}

Eigen::MatrixXf observed_place_response(Simulation &at_rest, double interval, int steps, int iterations,
                                        const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights, double force) {
    const Field rest = rest_positions(at_rest.scene()), none = Field::Zero(3, rest.cols());
    Eigen::MatrixXf response(rest.size(), 3 * weights.rows());
    for (Eigen::Index column = 0; column < response.cols(); ++column) {
        Field forces = none;
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(weights, column / 3); entry; ++entry)
            forces(column % 3, entry.col()) = force * entry.value();
        at_rest.set_state(rest, none);
        at_rest.set_external_forces(forces);
        for (int s = 0; s < steps; ++s)
            at_rest.step(interval / steps, iterations);
        const Field moved = (at_rest.positions() - rest) / (interval * interval * force);
        response.col(column) = Eigen::Map<const Eigen::VectorXd>(moved.data(), moved.size()).cast<float>();
    }
    return response;
}

} // namespace livermark::interactive
