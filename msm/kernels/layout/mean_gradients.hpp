#pragma once

#include <span>
#include <vector>

#include "msm/dynamics/step_parts.hpp"
#include "msm/kernels/layout/volume_members.hpp"

namespace livermark::msm {

/// What springs that take the mean of the deformation gradient over a control volume around a node i ask of where its
/// neighbours are,
///     F = sum over neighbours j of (x_j - x_i) b_j^T,   b_j = sum over tetrahedra t with i and j of V_t / (4 V_i)
///     g_tj,
/// with the gradients g_tj of the barycentric coordinates at rest. These sum to zero in each tetrahedron, so x_i needs
/// none of its own. The part mu_t F of the stress inside tetrahedra is linear in positions too. It pulls i by
///     sum over neighbours j of k_j (x_j - x_i),   k_j = -sum over tetrahedra t with i and j of mu_t V_t g_ti . g_tj.
struct NeighbourGradient {
    int node;
    core::Vector3 gradient; ///< b_j [1/m]
    double stiffness;       ///< k_j [N/m]
};
using MeanGradient = std::vector<NeighbourGradient>;

/// Of one control volume. Neighbours whose tetrahedra are all removed stay, with zeros.
/// @param x        shape (3N) [m], at rest
/// @param members  of the volume
MeanGradient mean_gradient(const StepParts &parts, const Eigen::VectorXd &x, int volume, std::span<const int> members);

/// @param positions  shape (N) [m], at rest
/// @return shape (C), each by ascending node numbers; empty if there are no springs that take means of F around nodes
std::vector<MeanGradient> mean_gradients(const StepParts &parts, const std::vector<core::Vector3> &positions);

} // namespace livermark::msm
