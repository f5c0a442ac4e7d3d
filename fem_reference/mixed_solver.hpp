#pragma once

#include <memory>
#include <span>
#include <string>

#include "fem_reference/chosen_solver.hpp"
#include "fem_reference/constrained_solver.hpp"
#include "fem_reference/pressure_system.hpp"

namespace livermark::fem_reference {

/// [K D^T; D -C] [u; p] = [f; 0] with some displacements prescribed, by minimal residuals. The preconditioner is the
/// inverse of K that its solver has, and the exact inverse of the norm of the pressure; with these elements the number
/// of iterations depends neither on the mesh nor on Poisson's ratio. At the pressure that they end with K u = f - D^T p
/// is then solved as tightly as the solver of K can, so that the reactions balance the loads whatever the tolerance.
/// (C. C. Paige and M. A. Saunders 1975, SIAM J. Numer. Anal. 12(4); D. Silvester and A. Wathen 1994, SIAM J. Numer.
/// Anal. 31(5))
class MixedSolver {
  public:
    /// Of the residual in the norm of the preconditioner, over the first.
    static constexpr double default_tolerance = 1e-9;
    static constexpr int max_iterations = 1000;

    /// @param solver  of K; it and the pressure are kept alive by the caller, the pressure unchanged
    explicit MixedSolver(ChosenSolver &solver, const PressureSystem &pressure, double tolerance = default_tolerance);
    ~MixedSolver();
    MixedSolver(MixedSolver &&) noexcept;
    MixedSolver &operator=(MixedSolver &&) noexcept;

    /// Sets up the solver of K if need be, and solves.
    /// @param prescribed  shape (3 n), NaN where a displacement is free
    /// @param load        shape (3 n) [N]
    /// @return residual K u + D^T p - f; energy 1/2 (u^T K u + p^T C p)
    ConstrainedSolution solve(std::span<const double> prescribed, std::span<const double> load);

    /// For the result file.
    std::string description(const ConstrainedSolution &solution) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace livermark::fem_reference
