#pragma once

namespace livermark::fem_reference {

/// How linear systems are solved: sparse Cholesky (CHOLMOD), or conjugate gradients with algebraic multigrid (Trilinos
/// ML). Automatic means sparse Cholesky up to largest_direct_system unknowns.
enum class SolverChoice { automatic, direct, iterative };

/// Beyond it the factor of a quadratic system of tetrahedra takes more memory and time than it is worth.
inline constexpr int largest_direct_system = 250'000;

} // namespace livermark::fem_reference
