#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "msm/dynamics/step_parts.hpp"

namespace livermark::msm {

/// The tetrahedra that give a quarter of themselves to each control volume, removed ones included.
struct VolumeMembers {
    std::vector<int> start;      ///< (C + 1) where those of each begin
    std::vector<int> tetrahedra; ///< ascending for each

    std::span<const int> of(int volume) const {
        return std::span(tetrahedra).subspan(start[volume], start[volume + 1] - start[volume]);
    }
};

VolumeMembers volume_members(const StepParts &parts);

/// Of each tetrahedron at rest, removed ones included [m^3].
/// @param x  shape (3N) [m], at rest
std::vector<double> rest_volumes(const StepParts &parts, const Eigen::VectorXd &x);

/// V0_c of a control volume around a node: a quarter of each of its tetrahedra that are there [m^3].
/// @param volumes  of tetrahedra, from rest_volumes()
/// @param members  of the control volume
double rest_volume(const StepParts &parts, std::span<const double> volumes, std::span<const int> members);

} // namespace livermark::msm
