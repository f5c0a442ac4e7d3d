#pragma once

namespace livermark::fem_reference {

/// Unknowns.
enum class Formulation {
    displacement, ///< u alone
    mixed         ///< and the pressure p = lambda div u of what is nearly incompressible, see PressureSystem
};

/// Solver of linear systems: sparse Cholesky (CHOLMOD), or conjugate gradients with algebraic multigrid (Trilinos
/// ML). Automatic means sparse Cholesky up to largest_direct_system unknowns; of quadratic elements up to
/// largest_direct_quadratic_system, and two levels beyond it: see Corners.
enum class SolverChoice { automatic, direct, iterative };

/// Beyond it the factor of a quadratic system of tetrahedra takes more memory and time than it is worth.
inline constexpr int largest_direct_system = 250'000;
/// On 220,000 unknowns the factor takes 52 s of a core, two levels and a solution by them a few.
inline constexpr int largest_direct_quadratic_system = 100'000;
/// Of the linear elements that are the coarse level of quadratic ones, see Corners: an approximate inverse is enough
/// there. Beyond it multigrid, whose memory and time grow with the unknowns.
inline constexpr int largest_direct_coarse_system = 100'000;

} // namespace livermark::fem_reference
