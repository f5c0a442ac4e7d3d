#include "fem_reference/mixed_solver.hpp"

#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/solver_minres.h>
#include <deal.II/lac/vector.h>

#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "fem_reference/mass_matrix.hpp"

namespace livermark::fem_reference {

namespace {

using Vector = dealii::Vector<double>;

std::span<double> part(Vector &vector, std::size_t first, std::size_t count) {
    return {vector.begin() + first, count};
}

std::span<const double> part(const Vector &vector, std::size_t first, std::size_t count) {
    return {vector.begin() + first, count};
}

/// The block matrix on free displacements; prescribed ones are zero in what comes out.
struct BlockMatrix {
    const ChosenSolver &solver;
    const PressureSystem &pressure;
    const std::vector<bool> &is_free;

    /// force = K u + D^T p, and imbalance = D u - C p
    void apply(std::span<const double> u, std::span<const double> p, std::span<double> force,
               std::span<double> imbalance) const {
        solver.multiply(u, force);
        multiply(pressure.compliance, p, imbalance);
        const auto &[row_start, column, value] = pressure.divergence;
        for (std::size_t q = 0; q < p.size(); ++q) {
            double divergence = 0.0;
            for (int k = row_start[q]; k < row_start[q + 1]; ++k) {
                divergence += value[k] * u[column[k]];
                force[column[k]] += value[k] * p[q];
            }
            imbalance[q] = divergence - imbalance[q];
        }
    }

    void vmult(Vector &out, const Vector &in) const {
        const std::size_t num_u = is_free.size(), num_p = in.size() - num_u;
        const auto force = part(out, 0, num_u);
        apply(part(in, 0, num_u), part(in, num_u, num_p), force, part(out, num_u, num_p));
        for (std::size_t i = 0; i < num_u; ++i)
            if (!is_free[i])
                force[i] = 0.0;
    }
};

struct BlockPreconditioner {
    Preconditioner &inverse;
    ConstrainedSolver &norm;
    std::size_t num_u;

    void vmult(Vector &out, const Vector &in) const {
        const std::size_t num_p = in.size() - num_u;
        inverse.apply(part(in, 0, num_u), part(out, 0, num_u));
        norm.solve_held(part(in, num_u, num_p), part(out, num_u, num_p));
    }
};

} // namespace

struct MixedSolver::Impl {
    Impl(ChosenSolver &of_k, const PressureSystem &p, double of_residual)
        : solver(of_k), pressure(p), tolerance(of_residual), norm(pressure.norm) {
        const std::vector<double> all_free(static_cast<std::size_t>(pressure.num_pressures()),
                                           std::numeric_limits<double>::quiet_NaN());
        norm.factorise(all_free);
    }

    ChosenSolver &solver;
    const PressureSystem &pressure;
    double tolerance;
    ConstrainedSolver norm; ///< nothing is held

    /// Adds to u what balances the forces at the free unknowns, with the prescribed ones where they are.
    /// @param residual  shape (n) K u + D^T p - f
    /// @param size      of the forces at work: what is left is to be small beside them, not beside what there is
    /// @return whether the solver of K converged
    bool balance(std::span<const double> prescribed, std::span<const double> residual, double size,
                 std::vector<double> &u) {
        std::vector<double> held(u.size()), load(u.size());
        for (std::size_t i = 0; i < u.size(); ++i) {
            held[i] = std::isnan(prescribed[i]) ? prescribed[i] : 0.0;
            load[i] = -residual[i];
        }
        const auto correction = solver.solve(held, load, size);
        for (std::size_t i = 0; i < u.size(); ++i)
            u[i] += correction.displacement[i];
        return correction.converged;
    }
};

MixedSolver::MixedSolver(ChosenSolver &solver, const PressureSystem &pressure, double tolerance)
    : impl_(std::make_unique<Impl>(solver, pressure, tolerance)) {}
MixedSolver::~MixedSolver() = default;
MixedSolver::MixedSolver(MixedSolver &&) noexcept = default;
MixedSolver &MixedSolver::operator=(MixedSolver &&) noexcept = default;

ConstrainedSolution MixedSolver::solve(std::span<const double> prescribed, std::span<const double> load) {
    const std::size_t num_u = prescribed.size();
    const auto num_p = static_cast<std::size_t>(impl_->pressure.num_pressures());
    std::vector<bool> is_free(num_u);
    for (std::size_t i = 0; i < num_u; ++i)
        is_free[i] = std::isnan(prescribed[i]);

    ConstrainedSolution solution;
    auto &inverse = impl_->solver.inverse();
    solution.unique = inverse.set_up(is_free);
    if (!solution.unique)
        return solution;

    auto &u = solution.displacement;
    u.resize(num_u);
    for (std::size_t i = 0; i < num_u; ++i)
        u[i] = is_free[i] ? 0.0 : prescribed[i];
    std::vector<double> p(num_p, 0.0), imbalance(num_p);
    solution.residual.resize(num_u);
    const BlockMatrix matrix{impl_->solver, impl_->pressure, is_free};
    matrix.apply(u, p, solution.residual, imbalance);

    Vector right_hand_side(num_u + num_p), unknowns(num_u + num_p);
    for (std::size_t i = 0; i < num_u; ++i)
        right_hand_side[i] = is_free[i] ? load[i] - solution.residual[i] : 0.0;
    for (std::size_t q = 0; q < num_p; ++q)
        right_hand_side[num_u + q] = -imbalance[q];
    const double size = right_hand_side.l2_norm();
    const auto forces = part(std::as_const(right_hand_side), 0, num_u);
    const double size_of_forces = std::sqrt(dot(forces, forces));
    dealii::ReductionControl control(max_iterations, 0.0, impl_->tolerance);
    try {
        if (size > 0.0)
            dealii::SolverMinRes<Vector>(control).solve(matrix, unknowns, right_hand_side,
                                                        BlockPreconditioner{inverse, impl_->norm, num_u});
        solution.iterations = static_cast<int>(control.last_step());
    } catch (const dealii::SolverControl::NoConvergence &ending) {
        solution.converged = false;
        solution.iterations = static_cast<int>(ending.last_step);
    }

    for (std::size_t i = 0; i < num_u; ++i)
        u[i] += unknowns[i];
    std::ranges::copy(part(unknowns, num_u, num_p), p.begin());
    matrix.apply(u, p, solution.residual, imbalance);
    for (std::size_t i = 0; i < num_u; ++i)
        solution.residual[i] -= load[i];
    solution.converged = impl_->balance(prescribed, solution.residual, size_of_forces, u) && solution.converged;
    matrix.apply(u, p, solution.residual, imbalance);
    solution.energy = 0.5 * dot(u, solution.residual);
    double left = dot(imbalance, imbalance);
    for (std::size_t i = 0; i < num_u; ++i) {
        solution.residual[i] -= load[i];
        left += is_free[i] ? solution.residual[i] * solution.residual[i] : 0.0;
    }
    solution.relative_residual = size > 0.0 ? std::sqrt(left) / size : 0.0;
    return solution;
}

std::string MixedSolver::description(const ConstrainedSolution &solution) const {
    return fmt::format("MINRES, {} iterations, {} and the mass of the pressure", solution.iterations,
                       impl_->solver.inverse().name());
}

} // namespace livermark::fem_reference
