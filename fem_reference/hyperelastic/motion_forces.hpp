#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/support/factors/sparse_cholesky.hpp"
#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/surface.hpp"

namespace livermark::hyperelastic {

/// The matrix m M + k K of an implicit step on what is free, with the consistent mass M and the tangent stiffness K of
/// a state, and its sparse Cholesky factor (CHOLMOD). n is the number of nodes.
class EffectiveMass {
  public:
    /// @param elements  in displacements alone; kept alive by the caller
    /// @param is_free   shape (3 n)
    EffectiveMass(const Elements &elements, std::vector<bool> is_free);

    /// out = M x
    /// @param x, out  shape (3 n)
    void multiply_mass(std::span<const double> x, std::span<double> out) const;

    /// Factors m M + k K. Where that is not positive definite, because the state is unstable, K is that at rest.
    /// @param displacement  of the state, shape (3 n) [m], without an element inside out
    /// @param surface       whose symmetric parts K gets, too
    void factorise(double m, double k, const std::vector<double> &displacement, const SurfaceStiffness &surface = {});

    /// (m M + k K) x = b with the last factor, in single precision: for iterations that correct it.
    /// @param b, x  shape (3 n); what is not free does not count, and is zero
    void solve(std::span<const double> b, std::span<double> x) const;

  private:
    bool factorise(double m, double k);

    const Elements *elements_;
    std::vector<bool> is_free_;
    fem_reference::SymmetricMatrix mass_; ///< (n, n), of one component
    TangentMatrices tangent_;
    std::vector<int> number_; ///< (3 n) of each free unknown among these, -1 where not free
    int num_free_ = 0;
    std::vector<int> start_, entry_; ///< rows of the lower triangle on what is free, and so columns of the upper one
    support::SparseCholesky cholesky_;
    bool is_ordered_ = false;
};

/// Internal forces of a step in time by the energy-momentum method. Between displacements u_0 and u_1, a step of length
/// h apart, they do the work by which the energy changes, but for what viscosity takes:
///     f_a = integral of F_m (S + beta (S_1 - S_0) / h) grad N_a,   F_m = (F_0 + F_1) / 2,
///     S = S(C_m) + 2 (W_1 - W_0 - S(C_m) : dC / 2) dC / (dC : dC),   C_m = (C_0 + C_1) / 2,   dC = C_1 - C_0,
/// with the second Piola-Kirchhoff stress S = 2 dW/dC. The stress S changes with squared lengths only, so rigid motions
/// are free of viscous forces, and momentum and angular momentum do not change.
/// (O. Gonzalez 2000, Exact energy and momentum conserving algorithms for general models in nonlinear elasticity,
/// Comput. Methods Appl. Mech. Engrg. 190, eq. 43; J. C. Simo, N. Tarnow 1992, The discrete energy-momentum method,
/// Z. angew. Math. Phys. 43; the viscosity is Kelvin's and Voigt's, and at small strain Rayleigh's beta K)
///
/// n is the number of nodes.
class MotionForces {
  public:
    /// @param elements   in displacements alone; kept alive by the caller
    /// @param rule       that they were made with
    /// @param viscosity  beta [s], >= 0
    /// @throws std::invalid_argument for mixed elements
    MotionForces(const Elements &elements, TetrahedronRule rule, double viscosity);

    /// Sets where a step begins.
    /// @param displacement  u_0, shape (3 n) [m], without an element inside out
    /// @return strain energy there [J]
    double begin_at(std::span<const double> displacement);

    /// End of a step.
    struct AtEnd {
        bool is_possible = false;  ///< no element is inside out; otherwise nothing else is set
        double energy = 0.0;       ///< strain energy at u_1 [J]
        std::vector<double> force; ///< (3 n) f [N]
    };
    /// @param displacement  u_1, shape (3 n) [m]
    /// @param time_step     h [s], > 0
    void end_at(std::span<const double> displacement, double time_step, AtEnd &result) const;

  private:
    /// State of a point of integration where the step begins.
    struct Point {
        Matrix3 deformation; ///< F_0
        Matrix3 stress;      ///< S_0 [Pa]
        double energy;       ///< W_0 [Pa]
    };
    template <int nodes> double begin(std::span<const double> displacement);
    template <int nodes> void end(std::span<const double> displacement, double time_step, AtEnd &result) const;

    const Elements *elements_;
    ReferenceTetrahedron reference_;
    double viscosity_;
    std::vector<Matrix3> inverse_edges_; ///< (M) of the matrix of the edges from the first corner [1/m]
    std::vector<double> volume_;         ///< (M) [m^3]
    std::vector<Point> start_;           ///< (M, Q)
};

} // namespace livermark::hyperelastic
