#pragma once

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
