#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// A rule that gives every edge of a mesh its stiffness. One file each in spring_laws/, named as the law.
struct SpringLaw {
    std::string name;    ///< the file stem; set by the table
    std::string summary; ///< one line
    std::string source;  ///< literature reference
    /// Stiffness of each edge.
    /// @param body   positive volumes, one material per region
    /// @param edges  of the body's mesh
    /// @return shape (S) [N/m], > 0
    std::function<std::vector<double>(const core::Body &body, const core::EdgeTable &edges)> stiffness;
    /// Stiffness that a tetrahedron adds to its six edges, in the order of core::tetrahedron_edges [N/m], where the
    /// stiffness of an edge is the sum of this over the tetrahedra around it; null for laws that look at the whole
    /// body.
    std::array<double, 6> (*edge_stiffness)(const core::Body &body, std::size_t tetrahedron) = nullptr;
};

/// A law that is such a sum, its stiffness included.
SpringLaw law_of_tetrahedra(std::string summary, std::string source,
                            std::array<double, 6> (*edge_stiffness)(const core::Body &body, std::size_t tetrahedron));

/// Every law of spring_laws/, in alphabetical order.
std::span<const SpringLaw> all_spring_laws();

/// The law patch with another weight of the forces, against 1 of isotropy.
/// @param weight_of_forces  > 0
SpringLaw patch_with(double weight_of_forces);

/// Solution of the fit of that law.
struct BoundedLeastSquares {
    Eigen::VectorXd x;  ///< (n) the minimiser; where the bound holds it back, the bound itself
    int num_solves = 0; ///< of sparse systems, by conjugate gradients
};

/// Sparse linear least squares with lower bounds: the x >= lower that minimises |A x - b|^2.
///
/// Block principal pivoting on the normal equations (Portugal, Judice, Vicente 1994, Math. Comp. 63(208); in this form
/// Kim, Park 2011, SIAM J. Sci. Comput. 33(6)): solve for the free unknowns, let every unknown change sides that is
/// below its bound, or at it and pushed inwards, and repeat. If that has not brought down their number in three goes,
/// only the last of them changes sides (Murty's rule), which ends for every positive definite A^T A. At the end the
/// conditions of Karush, Kuhn and Tucker hold to 1e-10 of the size of the problem: with columns of length one, no
/// gradient A^T (A x - b) points below zero, nor off it where x is free, by more than that part of |b - A lower|.
/// The same input gives the same x on one machine.
/// Columns that depend on each other have several minimisers, and this is one.
/// @param matrix  A, shape (m, n), no column zero
/// @param target  b, shape (m)
/// @param lower   shape (n), finite
/// @throws std::invalid_argument if the shapes differ, or if a column is zero or not finite
/// @throws std::runtime_error    if the columns depend on each other so nearly that no minimiser is found
BoundedLeastSquares solve_bounded_least_squares(const Eigen::SparseMatrix<double> &matrix,
                                                const Eigen::VectorXd &target, const Eigen::VectorXd &lower);

/// Tension of a spring against its stretch s = l / l0, all without units: with k its stiffness at rest, a spring has
/// the energy k l0^2 energy(s) [J], pulls its ends together with k l0 force(s) [N], and gets stiffer by slope(s).
/// energy(1) = force(1) = 0 and slope(1) = 1, and each is the derivative of the one before.
struct ForceCurve {
    double (*energy)(double stretch);
    double (*force)(double stretch);
    double (*slope)(double stretch);
};

/// Forces in proportion to elongations.
inline constexpr ForceCurve hooke{
    .energy = [](double stretch) { return 0.5 * (stretch - 1.0) * (stretch - 1.0); },
    .force = [](double stretch) { return stretch - 1.0; },
    .slope = [](double /*stretch*/) { return 1.0; },
};

/// A curve that all springs of a body have, instead of Hooke's. One file each in spring_curves/, named as the curve.
struct SpringCurve {
    std::string name;    ///< the file stem; set by the table
    std::string summary; ///< half a line
    std::string source;  ///< literature reference
    ForceCurve curve;
};

/// Every curve of spring_curves/, in alphabetical order.
std::span<const SpringCurve> all_spring_curves();

/// A way in which a body resists changes of its volume, beside its springs. Central springs are a solid with the first
/// Lame parameter lambda = mu; a volume term with the modulus kappa = lambda - mu makes of it any other. One file each
/// in volume_terms/, named as the term.
struct VolumeTerm {
    std::string name;    ///< the file stem; set by the table
    std::string summary; ///< half a line, to be read after "with"
    std::string source;  ///< literature reference
    /// @param body     at rest, positive volumes
    /// @param modulus  kappa of each region, shape (R) [Pa]; negative where Poisson's ratio is below 1/4
    std::shared_ptr<const ElasticTerm> (*make)(const core::Body &body, const std::vector<double> &modulus);
};

/// Every term of volume_terms/, in alphabetical order.
std::span<const VolumeTerm> all_volume_terms();

} // namespace livermark::msm
