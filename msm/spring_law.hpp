#pragma once

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
    std::vector<double> (*stiffness)(const core::Body &body, const core::EdgeTable &edges);
};

/// Every law of spring_laws/, in alphabetical order.
std::span<const SpringLaw> all_spring_laws();

} // namespace livermark::msm
