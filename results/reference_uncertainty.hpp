#pragma once

#include <string>

#include "core/problem.hpp"
#include "core/solution.hpp"

namespace livermark::results {

/// How far the reference itself is from the exact solution of linear elasticity on this body, as far as one can tell.
struct ReferenceUncertainty {
    std::string reference; ///< the model that all others are compared with
    std::string refined;   ///< the same elements on the mesh refined once
    /// core::Comparison::relative_l2 of the elements on the mesh against those on the refined mesh
    double refinement_difference = 0.0;
    double order = 0.0;          ///< of convergence in the mesh size that the estimate assumes
    double relative_l2 = 0.0;    ///< estimated error of the reference in the norm of core::Comparison
    double energy_error = 0.0;   ///< estimated, of its strain energy, relative, not signed
    double reaction_error = 0.0; ///< estimated, of its reactions, as in core::Comparison
    bool operator==(const ReferenceUncertainty &) const = default;
};

/// The order that estimates assume. Where a constrained part of a smooth boundary meets a free one, displacements go
/// with the square root of the distance (Grisvard 1985), and finite elements of any degree converge in L2 and in energy
/// with the first power of the mesh size only. Where nothing is singular the order is higher, and the estimate too
/// large.
inline constexpr double order_at_patch_edges = 1.0;

/// Estimates the errors of the elements on the mesh and on the refined mesh from their difference d (Richardson): of
/// errors C h^p, the coarse one is d / (1 - 2^-p) and the fine one d / (2^p - 1). The finer solution is the reference
/// if the coarser one's relative_l2 is estimated to be above largest_coarse_error.
/// @param mesh     nodes of both
/// @param coarse   status ok
/// @param refined  at the nodes of the mesh, status ok, not zero everywhere
/// @throws std::invalid_argument if the shapes differ, or if refined is no solution
ReferenceUncertainty estimate_uncertainty(const core::TetraMesh &mesh, const core::Solution &coarse,
                                          const std::string &coarse_name, const core::Solution &refined,
                                          const std::string &refined_name);
inline constexpr double largest_coarse_error = 0.01;

} // namespace livermark::results
