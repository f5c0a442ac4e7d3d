#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/problem.hpp"

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
    /// What a tetrahedron adds to its six edges, in the order of core::tetrahedron_edges [N/m], where the stiffness of
    /// an edge is the sum of this over the tetrahedra around it; null for laws that look at the whole body.
    std::array<double, 6> (*of_tetrahedron)(const core::Body &body, std::size_t tetrahedron) = nullptr;
};

/// A law that is such a sum, its stiffness included.
SpringLaw law_of_tetrahedra(std::string summary, std::string source,
                            std::array<double, 6> (*of_tetrahedron)(const core::Body &body, std::size_t tetrahedron));

/// Every law of spring_laws/, in alphabetical order.
std::span<const SpringLaw> all_spring_laws();

/// The law patch with another weight of the forces, against 1 of isotropy.
/// @param weight_of_forces  > 0
SpringLaw patch_with(double weight_of_forces);

} // namespace livermark::msm
