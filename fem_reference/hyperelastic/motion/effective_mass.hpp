#pragma once

#include <span>
#include <vector>

#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/surface/surface_stiffness.hpp"
#include "support/factors/sparse_cholesky.hpp"

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

} // namespace livermark::hyperelastic
