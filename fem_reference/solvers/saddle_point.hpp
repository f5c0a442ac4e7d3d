#pragma once

#include <span>
#include <vector>

#include "fem_reference/linear/chosen_solver.hpp"
#include "fem_reference/linear/pressure_system.hpp"

namespace livermark::fem_reference {

/// The matrix [K D^T; D -C] on free displacements and all pressures, for vectors that are worked on together (see
/// columns.hpp): displacements (3 n, lanes), pressures (m, lanes).
struct SaddlePoint {
    const ChosenSolver &solver; ///< of K
    const PressureSystem &pressure;
    const DivergenceRows<float> &single_precision_divergence; ///< that of the pressure
    int lanes;
    std::span<const std::size_t> constrained; ///< entries of displacements that are not free, see constrained_entries()

    /// force = K u + D^T p, and imbalance = D u - C p
    void apply(std::span<const double> u, std::span<const double> p, std::span<double> force,
               std::span<double> imbalance) const;
    void apply(std::span<const float> u, std::span<const float> p, std::span<float> force,
               std::span<float> imbalance) const;
};

/// A right-hand side.
struct SaddlePointLoad {
    std::vector<double> f; ///< (3 n, lanes) zero where not free
    std::vector<double> g; ///< (m, lanes)
};

/// How iterations ended.
struct SaddlePointEnding {
    int iterations = 0;
    bool converged = true;
};

/// Solves [K D^T; D -C] [u; p] = [f; g] by generalised minimal residuals, preconditioned by the lower block triangle
/// with inverses, exact or not, of K and of the norm of the pressure: that takes a third of the iterations that minimal
/// residuals take with the diagonal alone. What is left in each column is measured as the preconditioner sees it, which
/// is nearly the error: in parts of the displacements and pressures of the whole load.
/// (Y. Saad and M. H. Schultz 1986, SIAM J. Sci. Stat. Comput. 7(3); H. C. Elman, D. J. Silvester and A. J. Wathen
/// 2014, Finite Elements and Fast Iterative Solvers)
/// @param inverse         of K, set up for the unknowns that are free
/// @param norm            of the pressure, factored with nothing constrained
/// @param tolerance       of each column
/// @param max_iterations  after how many it gives up
/// @param whole           the load, that tolerances are in parts of
/// @param left            what of it is to be solved for: all, or what a first guess leaves
/// @param u               shape (3 n, lanes), zero where not free
/// @param p               shape (m, lanes)
SaddlePointEnding solve(const SaddlePoint &matrix, Preconditioner &inverse, ConstrainedSolver &norm, double tolerance,
                        int max_iterations, const SaddlePointLoad &whole, const SaddlePointLoad &left,
                        std::span<double> u, std::span<double> p);

} // namespace livermark::fem_reference
