#pragma once

#include <Eigen/Core>
#include <array>

#include "core/tetra_mesh.hpp"

namespace livermark::msm {

/// Volume of a tetrahedron and its first derivatives.
struct VolumeGradient {
    double volume;                         ///< V [m^3], signed
    std::array<core::Vector3, 4> gradient; ///< dV/dx_a of the four corners [m^2]
};

/// @param x            positions, 3 i + component for node i [m]
/// @param tetrahedron  node numbers
VolumeGradient volume_gradient(const Eigen::VectorXd &x, const std::array<int, 4> &tetrahedron);

/// Second derivatives d2V / dx_a dx_b, rows and columns 3 a + component [m].
Eigen::Matrix<double, 12, 12> volume_hessian(const Eigen::VectorXd &x, const std::array<int, 4> &tetrahedron);

} // namespace livermark::msm
