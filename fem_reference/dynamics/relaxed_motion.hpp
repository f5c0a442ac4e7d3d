#pragma once

#include <span>
#include <vector>

#include "core/solution.hpp"
#include "fem_reference/linear/elastic_system.hpp"

namespace livermark::fem_reference {

/// State of a body that relaxes, with the memory of its branches.
struct RelaxedState {
    std::vector<double> displacement;          ///< (3 n) u [m]
    std::vector<std::vector<double>> branches; ///< (B) of (3 n) w_k [m], of which each branch bears D w_k
};

/// The volumetric and the deviatoric part of the stiffness of a body, K = V + D, in the two matrices that the assembly
/// gives: K, and K' = D + V / part of the body with other bulk moduli.
class SplitStiffness {
  public:
    /// @param whole, other  K and K', with one pattern; kept alive by the caller
    /// @param part          above 0, below 1
    SplitStiffness(const SymmetricBlocks<double> &whole, const SymmetricBlocks<double> &other, double part)
        : whole_(&whole), other_(&other), weight_(part / (1.0 - part)) {}

    /// @return V a + D b, shape (3 n) [N]
    std::vector<double> product(std::span<const double> a, std::span<const double> b) const;
    /// @return v V + d D, shape (3 n, 3 n)
    SymmetricMatrix combined(double v, double d) const;

  private:
    const SymmetricBlocks<double> *whole_, *other_;
    double weight_; ///< V = weight (K' - K)
};

/// Lets the tractions of a load case go at t = 0 and follows a linear body that relaxes, with its mass: Newmark's
/// average acceleration (release.hpp), over each step of which the branches are integrated exactly for a displacement
/// that is linear in time (core::BranchStep). With v_m the mean of the velocities before and after a step of length h,
///     (2 M / h + alpha M + beta K + h / 2 (V + a D)) v_m
///         = 2 M v / h + f - V u - D (remaining u + sum over branches of (1 + fade) / 2 w),   a = remaining + sum of
///         gain
///     u <- u + h v_m,   v <- 2 v_m - v,   w <- fade w + gain h v_m.
/// It is of second order. Rayleigh damping is that of the instant stiffness. The strain energy of a record is what V,
/// D and the springs of the branches store.
/// @param body, system      of each other
/// @param load_case         of that body's mesh, with its release and its slow history, of which only the series counts
/// @param start             at rest
/// @param steps_per_record  of equal length between two records, at least 1
/// @throws std::runtime_error if the memory does not hold the factor
core::History release_relaxed(const core::Body &body, const ElasticSystem &system, const SplitStiffness &stiffness,
                              const core::LoadCase &load_case, RelaxedState start, int steps_per_record = 1);

} // namespace livermark::fem_reference
