#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/support/factors/sparse_cholesky.hpp"
#include "fem_reference/solvers/matrices.hpp"
#include "fem_reference/solvers/two_level.hpp"

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

/// K u = f with some unknowns prescribed, by preconditioned conjugate gradients.
class IterativeSolver {
  public:
    /// Norm of the residual over that of the right-hand side of the free rows at which the iteration stops.
    static constexpr double tolerance = 1e-11;

    /// @param stiffness       symmetric positive semidefinite; kept alive and unchanged by the caller
    /// @param preconditioner  of this matrix
    /// @param max_iterations  after how many steps it gives up
    IterativeSolver(const SymmetricBlocks<double> &stiffness, std::unique_ptr<Preconditioner> preconditioner,
                    int max_iterations = 2000);

    /// Prepares the preconditioner, unless the same unknowns were prescribed last time.
    /// @param prescribed  shape (n), NaN where an unknown is free
    /// @return whether the conditions fix the solution
    bool set_up(std::span<const double> prescribed);

    /// Begin and end of iterations.
    struct Aim {
        std::span<const double> guess{}; ///< (n) of the solution; empty for zero
        double relative_residual = tolerance;
    };

    /// Sets up if need be, and solves. A solution that has not converged says so and is the last iterate.
    /// @param prescribed  shape (n), NaN where an unknown is free
    /// @param load        shape (n), loads on prescribed unknowns count in the residual
    ConstrainedSolution solve(std::span<const double> prescribed, std::span<const double> load, const Aim &aim);
    ConstrainedSolution solve(std::span<const double> prescribed, std::span<const double> load) {
        return solve(prescribed, load, Aim{});
    }

    Preconditioner &preconditioner() const { return *preconditioner_; }

    /// Seconds that the preconditioner in use took, also when it was made for an earlier solve.
    double setup_seconds() const { return setup_seconds_; }

  private:
    struct Ending {
        int iterations = 0;
        double relative_residual = 0.0;
    };
    /// u += K^-1 residual on the free unknowns that the preconditioner is set up for.
    /// @param residual  shape (n), zero where not free, used up
    /// @param constrained      entries that are not free, see constrained_entries()
    /// @param size      norm of the right-hand side
    /// @param goal      norm of the residual over that at which it stops
    Ending add_solution(std::span<double> residual, std::span<double> u, std::span<const std::size_t> constrained,
                        double size, double goal);

    const SymmetricBlocks<double> &stiffness_;
    std::unique_ptr<Preconditioner> preconditioner_;
    int max_iterations_;
    FreeUnknowns free_;
    double setup_seconds_ = 0.0;
};

/// A sparse Cholesky factor (CHOLMOD) of what is free of a matrix of 3 x 3 blocks whose places stay. n is the number of
/// nodes.
class BlockFactor {
  public:
    /// @param is_free  shape (3 n)
    BlockFactor(const LowerRows &rows, std::vector<bool> is_free);

    /// @param matrix  with these rows
    /// @return false if it is not positive definite; there is no factor then
    /// @throws std::runtime_error if CHOLMOD runs out of memory
    bool factorise(const SymmetricBlocks<double> &matrix);

    /// Solves with the last factor, in single precision: for iterations that correct it.
    /// @param b, x  shape (3 n); what is not free does not count, and is zero
    void solve(std::span<const double> b, std::span<double> x) const;

  private:
    std::vector<bool> is_free_;
    std::vector<int> number_; ///< (3 n) of each free unknown among these, -1 where not free
    int num_free_ = 0;
    std::vector<int> start_, entry_; ///< rows of the lower triangle on what is free, and so columns of the upper one
    support::SparseCholesky cholesky_;
    bool is_ordered_ = false;
};

} // namespace livermark::fem_reference
