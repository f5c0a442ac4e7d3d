#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "fem_reference/distributed/distributed_levels.hpp"
#include "fem_reference/linear/pressure_system.hpp"

namespace livermark::fem_reference {

/// [K + L, D^T; D, -C] as one rank has it on its part; results are right where this rank owns them.
struct MatricesOfPart {
    const SymmetricBlocks<double> &stiffness;
    const DivergenceRows<double> &divergence;
    const SymmetricMatrix &compliance;
    /// out += L x, or empty
    std::function<void(std::span<const double> x, std::span<double> out)> add_product{};

    /// force = (K + L) u + D^T p, and imbalance = D u - C p
    void apply(std::span<const double> u, std::span<const double> p, std::span<double> force,
               std::span<double> imbalance) const;
};

/// Displacements (3 n) and pressures (m) of a part.
struct MixedField {
    std::vector<double> u, p;
};

/// Solves the systems of mixed elements over all ranks, by generalised minimal residuals with the lower block triangle
/// of approximate inverses: DistributedLevels of K, and for the Schur complement polynomials of Chebyshev of the mass
/// of the pressure, whose spectrum over its diagonal is known ([1/2, 5/2]; A. J. Wathen 1987, IMA J. Numer. Anal.
/// 7(4)). The number of iterations hardly depends on the mesh, on Poisson's ratio and on how many ranks there are.
class DistributedSaddlePoint {
  public:
    /// Collective. All but what is moved are kept alive by the caller.
    /// @param system    quadratic elements assembled on the part; its numbering is used
    /// @param pressure  the same; its numbering and norm are used
    /// @param nodes     of the system, three components each
    /// @param scale     what pressures are divided by [Pa/m], see pressure_scale()
    /// @param is_free   shape (3 n), right for what other ranks own too
    DistributedSaddlePoint(const Part &part, const ElasticSystem &system, const PressureSystem &pressure,
                           const NodeExchange &nodes, const RigidModes &rigid, double scale, std::vector<bool> is_free);
    ~DistributedSaddlePoint();

    const NodeExchange &pressures() const;

    /// Collective. Makes the levels of K.
    void set_up(const SymmetricBlocks<double> &stiffness);

    struct Ending {
        bool converged = false;
        int iterations = 0;
        double relative_residual = 0.0; ///< as the preconditioner sees it, over the first
    };
    /// Collective, after a set_up().
    /// @param right      what is not free or owned does not count
    /// @param tolerance  of the residual as the preconditioner sees it, over the first
    /// @param found      also what other ranks own; zero where not free
    Ending solve(const MatricesOfPart &matrices, const MixedField &right, double tolerance, int max_iterations,
                 MixedField &found) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace livermark::fem_reference
