#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <array>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::msm {

/// Volume of a tetrahedron and its first derivatives.
struct VolumeGradient {
    double volume;                         ///< V [m^3], signed
    std::array<core::Vector3, 4> gradient; ///< dV/dx_a of the four corners [m^2]
};

/// @param x            positions, 3 i + component for node i [m]
/// @param tetrahedron  node numbers
inline VolumeGradient volume_gradient(const Eigen::VectorXd &x, const std::array<int, 4> &tetrahedron) {
    const auto corner = [&](int a) -> core::Vector3 {
        return x.segment<3>(3 * static_cast<Eigen::Index>(tetrahedron[a]));
    };
    const core::Vector3 origin = corner(0);
    const core::Vector3 a = corner(1) - origin, b = corner(2) - origin, c = corner(3) - origin;
    const core::Vector3 first = b.cross(c) / 6.0, second = c.cross(a) / 6.0, third = a.cross(b) / 6.0;
    return {.volume = a.dot(first), .gradient = {-(first + second + third), first, second, third}};
}

/// The derivative of the gradient along displacements u [m^2], if u is in m.
/// @param u  shape (3N) like x
inline std::array<core::Vector3, 4> volume_gradient_change(const Eigen::VectorXd &x, const Eigen::VectorXd &u,
                                                           const std::array<int, 4> &tetrahedron) {
    const auto corner = [&](const Eigen::VectorXd &field, int a) -> core::Vector3 {
        return field.segment<3>(3 * static_cast<Eigen::Index>(tetrahedron[a])) -
               field.segment<3>(3 * static_cast<Eigen::Index>(tetrahedron[0]));
    };
    const core::Vector3 a = corner(x, 1), b = corner(x, 2), c = corner(x, 3);
    const core::Vector3 p = corner(u, 1), q = corner(u, 2), r = corner(u, 3);
    const core::Vector3 first = (q.cross(c) + b.cross(r)) / 6.0, second = (r.cross(a) + c.cross(p)) / 6.0,
                        third = (p.cross(b) + a.cross(q)) / 6.0;
    return {-(first + second + third), first, second, third};
}

/// Second derivatives d2V / dx_a dx_b, rows and columns 3 a + component [m].
Eigen::Matrix<double, 12, 12> volume_hessian(const Eigen::VectorXd &x, const std::array<int, 4> &tetrahedron);

/// Puts such a block of one tetrahedron where its nodes are in a (3N, 3N) matrix.
void add_block(std::vector<Eigen::Triplet<double>> &entries, const std::array<int, 4> &tetrahedron,
               const Eigen::Matrix<double, 12, 12> &block);

} // namespace livermark::msm
