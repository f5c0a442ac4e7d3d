#include "fem_reference/solvers/saddle_point.hpp"

#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/solver_gmres.h>
#include <deal.II/lac/vector.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>

namespace livermark::fem_reference {

namespace {

/// Displacements of all columns, then pressures of all columns: one system.
using Vector = dealii::Vector<double>;
/// The same in the iterations, which keep some twenty of them: half the memory to go through.
using KrylovVector = dealii::Vector<float>;

/// How far one round of iterations may go: in single precision what they believe to be left differs from what is left.
constexpr double furthest_round = 2e-5;
/// A round that ends further than it was told to begins another one.
constexpr double reserve = 0.5;
/// What is left as the preconditioner sees it is less than the error, where it is a pressure that the mass of pressures
/// takes for smaller than it is.
constexpr double seen_of_tolerance = 0.4;
/// Vectors of a Krylov space; a round takes about twenty.
constexpr int largest_space = 40;

template <class T> std::span<T> part(dealii::Vector<T> &vector, std::size_t first, std::size_t count) {
    return {vector.begin() + first, count};
}

template <class T> std::span<const T> part(const dealii::Vector<T> &vector, std::size_t first, std::size_t count) {
    return {vector.begin() + first, count};
}

/// The matrix and its preconditioner, pressures of each column in a unit of their own.
struct Scaled {
    const SaddlePoint &matrix;
    Preconditioner &inverse;
    ConstrainedSolver &norm;
    std::size_t num_u, num_p; ///< of all columns
    std::vector<double> unit; ///< (lanes) [Pa/m]

    /// For the iterations.
    struct Preconditioning {
        const Scaled &of;
        void vmult(KrylovVector &out, const KrylovVector &in) const { of.precondition(out, in); }
    };

    template <class T> void vmult(dealii::Vector<T> &out, const dealii::Vector<T> &in) const {
        const auto of_p = part(in, num_u, num_p);
        std::vector<T> p(of_p.begin(), of_p.end());
        scale(unit, p);
        const auto force = part(out, 0, num_u);
        matrix.apply(part(in, 0, num_u), p, force, part(out, num_u, num_p));
        zero(matrix.constrained, force);
    }

    /// u = K^-1 f, p = S^-1 (D u - g)
    void precondition(KrylovVector &out, const KrylovVector &in) const {
        const auto u = part(out, 0, num_u), p = part(out, num_u, num_p);
        inverse.apply(part(in, 0, num_u), u);
        std::vector<float> imbalance(num_p);
        matrix.single_precision_divergence.subtract_product(u, part(in, num_u, num_p), imbalance, matrix.lanes);
        std::vector<int> columns(matrix.lanes);
        std::iota(columns.begin(), columns.end(), 0);
        norm.solve_single_precision(imbalance, p, matrix.lanes, columns);
        auto per_unit = unit;
        for (double &value : per_unit)
            value = 1.0 / value;
        scale(per_unit, p);
    }
};

/// right_hand_side - A unknowns
Vector residual(const Scaled &system, const Vector &right_hand_side, const Vector &unknowns) {
    Vector left(right_hand_side);
    system.vmult(left, unknowns);
    left.sadd(-1.0, 1.0, right_hand_side);
    return left;
}

void add(Vector &sum, const KrylovVector &summand) {
    std::ranges::transform(sum, summand, sum.begin(), std::plus<>());
}

/// Rounds of iterations until the preconditioned residual is small.
/// @param size      of the preconditioned load, of which the right-hand side may be a part
/// @param unknowns  zero
SaddlePointEnding iterate(const Scaled &system, double size, double goal, int max_iterations,
                          const Vector &right_hand_side, Vector &unknowns) {
    SaddlePointEnding ending;
    KrylovVector correction(right_hand_side.size()), to_solve(right_hand_side.size()), seen(right_hand_side.size());
    Vector left(right_hand_side);
    to_solve = left;
    while (size > goal) {
        dealii::ReductionControl control(max_iterations - ending.iterations, reserve * goal, furthest_round);
        correction = 0.0F;
        using Solver = dealii::SolverGMRES<KrylovVector>;
        try {
            Solver(control, Solver::AdditionalData(largest_space))
                .solve(system, correction, to_solve, Scaled::Preconditioning{system});
        } catch (const dealii::SolverControl::NoConvergence &) {
            ending.converged = false;
        }
        ending.iterations += static_cast<int>(control.last_step());
        add(unknowns, correction);
        left = residual(system, right_hand_side, unknowns);
        to_solve = left;
        system.precondition(seen, to_solve);
        const double before = size;
        size = seen.l2_norm();
        ending.converged = ending.converged && size < reserve * before;
        if (!ending.converged)
            break;
    }
    add(unknowns, seen); // as the preconditioner sees what is left: the solution gets better for nothing
    return ending;
}

template <class T>
void product(const SaddlePoint &matrix, const DivergenceRows<T> &divergence, std::span<const T> u, std::span<const T> p,
             std::span<T> force, std::span<T> imbalance) {
    matrix.solver.multiply(u, force);
    multiply(matrix.pressure.compliance, p, imbalance, matrix.lanes);
    divergence.add_products(u, p, force, imbalance, matrix.lanes);
}

} // namespace

void SaddlePoint::apply(std::span<const double> u, std::span<const double> p, std::span<double> force,
                        std::span<double> imbalance) const {
    product(*this, pressure.divergence, u, p, force, imbalance);
}

void SaddlePoint::apply(std::span<const float> u, std::span<const float> p, std::span<float> force,
                        std::span<float> imbalance) const {
    product(*this, single_precision_divergence, u, p, force, imbalance);
}

SaddlePointEnding solve(const SaddlePoint &matrix, Preconditioner &inverse, ConstrainedSolver &norm, double tolerance,
                        int max_iterations, const SaddlePointLoad &whole, const SaddlePointLoad &left,
                        std::span<double> u, std::span<double> p) {
    Scaled system{matrix, inverse, norm, u.size(), p.size(), std::vector<double>(matrix.lanes, 1.0)};
    Vector right_hand_side(u.size() + p.size()), unknowns(u.size() + p.size());
    const auto fill = [&](const SaddlePointLoad &load) {
        std::ranges::copy(load.f, right_hand_side.begin());
        std::ranges::copy(load.g, right_hand_side.begin() + u.size());
    };
    fill(whole);
    KrylovVector seen(right_hand_side.size()), to_see(right_hand_side.size());
    to_see = right_hand_side;
    system.precondition(seen, to_see);
    unknowns = seen;

    // Displacements and pressures of every column begin at one: what is left of all together is no less than of each.
    const auto first_u = part(unknowns, 0, u.size()), first_p = part(unknowns, u.size(), p.size());
    auto size = roots_of(dots(first_u, first_u, matrix.lanes));
    const auto size_of_p = roots_of(dots(first_p, first_p, matrix.lanes));
    auto per_size = size;
    int num_ones = 0;
    for (int c = 0; c < matrix.lanes; ++c) {
        num_ones += (size[c] > 0.0 ? 1 : 0) + (size_of_p[c] > 0.0 ? 1 : 0);
        if (size[c] > 0.0 && size_of_p[c] > 0.0)
            system.unit[c] = size_of_p[c] / size[c];
        else if (!(size[c] > 0.0))
            size[c] = size_of_p[c]; // loads that only change volumes
        per_size[c] = size[c] > 0.0 ? 1.0 / size[c] : 0.0;
    }
    unknowns = 0.0;
    fill(left);
    scale(per_size, {right_hand_side.begin(), right_hand_side.size()});
    const auto ending =
        iterate(system, std::sqrt(num_ones), seen_of_tolerance * tolerance, max_iterations, right_hand_side, unknowns);
    scale(system.unit, first_p);
    scale(size, {unknowns.begin(), unknowns.size()});
    std::ranges::copy(first_u, u.begin());
    std::ranges::copy(first_p, p.begin());
    return ending;
}

} // namespace livermark::fem_reference
