#pragma once

#include <cmath>
#include <optional>
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
    /// Estimated, of its stiffness at the tool, as in core::ToolComparison, not signed; nothing without a tool, and of
    /// references that were stored without it.
    std::optional<double> stiffness{};
    bool operator==(const ReferenceUncertainty &) const = default;
};

/// How far the motion that others are compared with is itself from the exact one.
struct MotionUncertainty {
    std::string reference; ///< the model whose motion all others are compared with: one of the two
    std::string refined;   ///< the one on finer meshes
    /// core::HistoryComparison::relative_l2 of the model on the mesh against the refined one; NaN where there is none
    double difference = 0.0;
    double order = 0.0;       ///< of convergence of the refined one, from mesh to mesh; without one in the steps
    double relative_l2 = 0.0; ///< estimated error of the reference, in the norm of core::HistoryComparison
    bool operator==(const MotionUncertainty &) const = default;

    /// Whether only the error of the steps is known, and not that of the mesh.
    bool is_of_steps_alone() const { return std::isnan(difference); }
};

/// The refined motion is off by what it has observed itself, or where it has not by as much as the two differ
/// (order_at_patch_edges on meshes of half the size). That on the mesh is off by the difference, and at most by that
/// besides; where it is estimated to be more than largest_coarse_error, the refined motion is the reference. What the
/// motion on the mesh has observed of its steps adds to both, of the refined motion with the square of the ratio of
/// their lengths.
/// @throws std::invalid_argument if they were recorded at other times or probes
MotionUncertainty estimate_motion_uncertainty(const core::History &coarse, const std::string &coarse_name,
                                              const core::History &refined, const std::string &refined_name);

/// What is known where no motion on finer meshes is there: of the steps alone, or nothing.
std::optional<MotionUncertainty> uncertainty_of_steps(const core::History &motion, const std::string &name);

/// The order that estimates assume. Where a constrained part of a smooth boundary meets a free one, displacements go
/// with the square root of the distance (Grisvard 1985), and finite elements of any degree converge in L2 and in energy
/// with the first power of the mesh size only. Where nothing is singular the order is higher, and the estimate too
/// large.
inline constexpr double order_at_patch_edges = 1.0;

/// Estimates the errors of the elements on the mesh and on the refined mesh from their difference d (Richardson): of
/// errors C h^p, the coarse one is d / (1 - 2^-p) and the fine one d / (2^p - 1). The finer solution is the reference
/// if the coarser one's relative_l2 is estimated to be above largest_coarse_error.
/// @param mesh, load_case  of both
/// @param coarse   status ok
/// @param refined  at the nodes of the mesh, status ok, not zero everywhere
/// @throws std::invalid_argument if the shapes differ, or if refined is no solution
ReferenceUncertainty estimate_uncertainty(const core::TetraMesh &mesh, const core::LoadCase &load_case,
                                          const core::Solution &coarse, const std::string &coarse_name,
                                          const core::Solution &refined, const std::string &refined_name);
inline constexpr double largest_coarse_error = 0.01;

} // namespace livermark::results
