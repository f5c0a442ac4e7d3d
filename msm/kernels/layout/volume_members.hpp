#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "msm/cutting/number_lists.hpp"
#include "msm/dynamics/step_parts.hpp"

namespace livermark::msm {

/// The tetrahedra that give a quarter of themselves to each control volume, ascending, removed ones included.
inline NumberLists volume_members(const StepParts &parts) {
    return NumberLists(parts.corner_volume, parts.centre.size());
}

/// Of each tetrahedron at rest, removed ones included [m^3].
/// @param x  shape (3N) [m], at rest
std::vector<double> rest_volumes(const StepParts &parts, const Eigen::VectorXd &x);

/// V0_c of a control volume around a node: a quarter of each of its tetrahedra that are there [m^3].
/// @param volumes  of tetrahedra, from rest_volumes()
/// @param members  of the control volume
double rest_volume(const StepParts &parts, std::span<const double> volumes, std::span<const int> members);

} // namespace livermark::msm
