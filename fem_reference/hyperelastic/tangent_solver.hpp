#pragma once

#include <memory>
#include <vector>

#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/surface.hpp"

namespace livermark::hyperelastic {

/// The linear systems of Newton's method,
///     [K + L, D^T; D, -C] [du; dp] = [f; g]
/// on free displacements and all pressures, with L the stiffness of the surface under follower pressures and contact,
/// which need not be symmetric. Generalised minimal residuals (deal.II) solve them with the true matrix, preconditioned
/// by the lower block triangle of an approximate inverse of a K with the part of L that is put there
/// (SurfaceStiffness), and of the norm of the pressure (fem_reference::PressureSystem) for the Schur complement. The
/// approximate inverse is
/// - in displacements alone a sparse Cholesky factor (CHOLMOD), because what is coarser locks;
/// - with a pressure two levels (fem_reference::two_level()), the linear elements of the same tetrahedra below.
/// It may be that of an earlier state: then there are more iterations, and the solution is the same within the
/// tolerance.
class TangentSolver {
  public:
    /// Remainder of the first residual, as the preconditioner sees it, in the norm of displacements and scaled
    /// pressures: little enough that Newton's method converges as with exact solves.
    static constexpr double smallest_tolerance = 1e-9;
    static constexpr int max_iterations = 200;

    /// @param elements  kept alive by the caller
    /// @param is_free   shape (3 n)
    TangentSolver(const Elements &elements, std::vector<bool> is_free);
    ~TangentSolver();

    /// A pressure in the units of displacement is a pressure over this [Pa/m]: the mean shear modulus over the cube
    /// root of the volume.
    double pressure_scale() const;

    /// Prepares the approximate inverse of K for the solves to come.
    /// @return false if it, or the coarse level, is not positive definite; there is no inverse then
    /// @throws std::runtime_error if CHOLMOD runs out of memory
    bool factorise(const fem_reference::SymmetricBlocks<double> &stiffness);

    /// Result of a solve.
    struct Correction {
        bool converged = false;
        int iterations = 0;
        State change; ///< zero where displacements are not free
    };
    /// Only after a factorise() that returned true.
    /// @param tangent  K with the symmetric part of L, and D
    /// @param surface  L
    /// @param right    f [N], shape (3 n), and g [m^3], shape (m); what is not free does not count
    /// @param tolerance  what may be left of the first residual
    Correction solve(const TangentMatrices &tangent, const SurfaceStiffness &surface, const State &right,
                     double tolerance) const;

    /// Whether the inverse is a factor of all unknowns.
    bool is_direct() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace livermark::hyperelastic
