#include "fem_reference/saddle_point.hpp"

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
/// The same as the iterations keep some twenty of them: half the memory to go through.
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

std::span<double> part(Vector &vector, std::size_t first, std::size_t count) {
    return {vector.begin() + first, count};
}

std::span<const double> part(const Vector &vector, std::size_t first, std::size_t count) {
    return {vector.begin() + first, count};
}

/// The matrix and its preconditioner, pressures of each column in a unit of their own.
struct Scaled {
    const SaddlePoint &matrix;
    Preconditioner &inverse;
    ConstrainedSolver &norm;
    std::size_t num_u, num_p; ///< of all columns
    std::vector<double> unit; ///< (lanes) [Pa/m]

    /// One of the two that follow, for the iterations.
    struct Operator {
        const Scaled &of;
        void (Scaled::*apply)(Vector &out, const Vector &in) const;
        mutable Vector in{}, out{};

        void vmult(KrylovVector &result, const KrylovVector &vector) const {
            in.reinit(vector.size(), true);
            out.reinit(vector.size(), true);
            std::ranges::copy(vector, in.begin());
            (of.*apply)(out, in);
            std::ranges::copy(out, result.begin());
        }
    };

    void multiply(Vector &out, const Vector &in) const {
        const auto of_p = part(in, num_u, num_p);
        std::vector<double> p(of_p.begin(), of_p.end());
        scale(unit, p);
        const auto force = part(out, 0, num_u);
        matrix.apply(part(in, 0, num_u), p, force, part(out, num_u, num_p));
        zero(matrix.held, force);
    }

    /// u = K^-1 f, p = S^-1 (D u - g)
    void precondition(Vector &out, const Vector &in) const {
        const auto u = part(out, 0, num_u), p = part(out, num_u, num_p);
        inverse.apply(part(in, 0, num_u), u);
        std::vector<double> imbalance(num_p);
        matrix.divergence_less(u, part(in, num_u, num_p), imbalance);
        std::vector<int> columns(matrix.lanes);
        std::iota(columns.begin(), columns.end(), 0);
        norm.solve_roughly(imbalance, p, matrix.lanes, columns);
        auto per_unit = unit;
        for (double &value : per_unit)
            value = 1.0 / value;
        scale(per_unit, p);
    }
};

/// right_hand_side - A unknowns
Vector residual(const Scaled &system, const Vector &right_hand_side, const Vector &unknowns) {
    Vector left(right_hand_side);
    system.multiply(left, unknowns);
    left.sadd(-1.0, 1.0, right_hand_side);
    return left;
}

/// Rounds of iterations until the preconditioned residual is small.
/// @param size      of the preconditioned load, of which the right-hand side may be a part
/// @param unknowns  zero
SaddlePointEnding iterate(const Scaled &system, double size, double goal, int max_iterations,
                          const Vector &right_hand_side, Vector &unknowns) {
    SaddlePointEnding ending;
    const Scaled::Operator product{system, &Scaled::multiply}, preconditioner{system, &Scaled::precondition};
    KrylovVector correction(right_hand_side.size()), to_solve(right_hand_side.size());
    Vector seen(right_hand_side.size()), left(right_hand_side);
    while (size > goal) {
        dealii::ReductionControl control(max_iterations - ending.iterations, reserve * goal, furthest_round);
        correction = 0.0F;
        std::ranges::copy(left, to_solve.begin());
        using Solver = dealii::SolverGMRES<KrylovVector>;
        try {
            Solver(control, Solver::AdditionalData(largest_space)).solve(product, correction, to_solve, preconditioner);
        } catch (const dealii::SolverControl::NoConvergence &) {
            ending.converged = false;
        }
        ending.iterations += static_cast<int>(control.last_step());
        std::ranges::transform(unknowns, correction, unknowns.begin(), std::plus<>());
        left = residual(system, right_hand_side, unknowns);
        system.precondition(seen, left);
        const double before = size;
        size = seen.l2_norm();
        ending.converged = ending.converged && size < reserve * before;
        if (!ending.converged)
            break;
    }
    unknowns += seen; // what is left is known as the preconditioner sees it: it makes the answer better for nothing
    return ending;
}

} // namespace

void SaddlePoint::apply(std::span<const double> u, std::span<const double> p, std::span<double> force,
                        std::span<double> imbalance) const {
    solver.multiply(u, force);
    multiply(pressure.compliance, p, imbalance, lanes);
    const auto &d = pressure.divergence;
    with_lanes(lanes, [&]<int L>() {
        for (std::size_t q = 0; q + 1 < d.row_start.size(); ++q) {
            std::array<double, L> divergence{}, of_row{};
            std::copy_n(&p[L * q], L, of_row.begin());
            for (int k = d.row_start[q]; k < d.row_start[q + 1]; ++k) {
                const auto place = static_cast<std::size_t>(L) * d.column[k];
                for (int c = 0; c < L; ++c) {
                    divergence[c] += d.value[k] * u[place + c];
                    force[place + c] += d.value[k] * of_row[c];
                }
            }
            for (int c = 0; c < L; ++c)
                imbalance[L * q + c] = divergence[c] - imbalance[L * q + c];
        }
    });
}

void SaddlePoint::divergence_less(std::span<const double> u, std::span<const double> g, std::span<double> out) const {
    const auto &d = pressure.divergence;
    with_lanes(lanes, [&]<int L>() {
        for (std::size_t q = 0; q + 1 < d.row_start.size(); ++q) {
            std::array<double, L> divergence{};
            for (int k = d.row_start[q]; k < d.row_start[q + 1]; ++k)
                for (int c = 0; c < L; ++c)
                    divergence[c] += d.value[k] * u[static_cast<std::size_t>(L) * d.column[k] + c];
            for (int c = 0; c < L; ++c)
                out[L * q + c] = divergence[c] - g[L * q + c];
        }
    });
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
    system.precondition(unknowns, right_hand_side);

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
