#pragma once

#include <memory>
#include <span>
#include <vector>

#include "fem_reference/solvers/matrices.hpp"

namespace livermark::fem_reference {

/// Result of a solve; n is the number of rows of the matrix.
struct ConstrainedSolution {
    bool unique = false;              ///< whether the conditions fix the solution; if not, the vectors are empty
    std::vector<double> displacement; ///< (n) u
    std::vector<double> residual;     ///< (n) K u - f: the reactions, and rounding at the free unknowns
    double energy = 0.0;              ///< 1/2 u^T K u
    bool converged = true;            ///< always for a direct solver
    int iterations = 0;               ///< of an iterative solver
    double relative_residual = 0.0;   ///< at which it stopped
};

/// The conditions of a solve, for n rows.
struct Conditions {
    std::span<const double> prescribed; ///< (n) NaN where an unknown is free
    std::span<const double> load;       ///< (n)
};

/// K u = f with some unknowns prescribed. The factor (sparse Cholesky, CHOLMOD) of the rows that are free is kept and
/// used again as long as the same unknowns are prescribed, whatever their values, or what prepare() was given and few
/// more.
class ConstrainedSolver {
  public:
    /// @param stiffness  symmetric positive semidefinite
    explicit ConstrainedSolver(SymmetricMatrix stiffness);
    ~ConstrainedSolver();
    ConstrainedSolver(ConstrainedSolver &&) noexcept;
    ConstrainedSolver &operator=(ConstrainedSolver &&) noexcept;

    /// Takes what more than one of the solves to come have prescribed, maybe among more: one factor serves them then,
    /// see support::SparseCholesky::constrain(). Their solutions differ from those of a factor of their own by
    /// rounding.
    /// @param prescribed  shape (n), NaN where an unknown is free
    void prepare(std::span<const double> prescribed);

    /// Factors, unless the same unknowns were prescribed last time.
    /// @param prescribed  shape (n), NaN where an unknown is free
    /// @return whether the conditions fix the solution
    /// @throws std::runtime_error if CHOLMOD runs out of memory
    bool factorise(std::span<const double> prescribed);

    /// Factorises if need be, and solves.
    /// @param prescribed  shape (n), NaN where an unknown is free
    /// @param load        shape (n), loads on prescribed unknowns count in the residual
    ConstrainedSolution solve(std::span<const double> prescribed, std::span<const double> load);

    /// Solves with the factor in use and the prescribed unknowns at zero, and looks at no residual: the inner step of
    /// iterations. Only after a factorise() that returned true.
    /// @param load  shape (n), those on prescribed unknowns do not count
    /// @param u     shape (n)
    void solve_constrained(std::span<const double> load, std::span<double> u);

    /// The same in single precision, which takes half of the time: for iterations that correct it.
    /// @param load     shape (n, lanes), see matrices.hpp
    /// @param u        shape (n, lanes)
    /// @param columns  to be solved for, each < lanes; the others are not looked at
    void solve_single_precision(std::span<const float> load, std::span<float> u, int lanes,
                                std::span<const int> columns);

    /// The same for a single vector.
    void solve_single_precision(std::span<const double> load, std::span<double> u);

    /// Seconds that the factor in use took, also when it was made for an earlier solve.
    double factor_seconds() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace livermark::fem_reference
