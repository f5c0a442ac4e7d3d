#include "msm/springs/tetrahedron_volume.hpp"

namespace livermark::msm {

namespace {

/// Edges from corner 0 to the others.
std::array<core::Vector3, 3> edges_from_first(const Eigen::VectorXd &x, const std::array<int, 4> &tetrahedron) {
    const auto corner = [&](int a) -> core::Vector3 {
        return x.segment<3>(3 * static_cast<Eigen::Index>(tetrahedron[a]));
    };
    const core::Vector3 origin = corner(0);
    return {corner(1) - origin, corner(2) - origin, corner(3) - origin};
}

/// The matrix of a x .
Eigen::Matrix3d cross_matrix(const core::Vector3 &a) {
    return (Eigen::Matrix3d() << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0).finished();
}

} // namespace

Eigen::Matrix<double, 12, 12> volume_hessian(const Eigen::VectorXd &x, const std::array<int, 4> &tetrahedron) {
    const auto edges = edges_from_first(x, tetrahedron);
    Eigen::Matrix<double, 12, 12> hessian = Eigen::Matrix<double, 12, 12>::Zero();
    // 6 dV/da = b x c, so that its derivative in b is -[c x] and in c [b x], and so on in a circle.
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3, last = (k + 2) % 3;
        hessian.block<3, 3>(3 * (k + 1), 3 * (next + 1)) = -cross_matrix(edges[last]) / 6.0;
        hessian.block<3, 3>(3 * (k + 1), 3 * (last + 1)) = cross_matrix(edges[next]) / 6.0;
    }
    // A common shift changes nothing.
    for (int k = 1; k < 4; ++k)
        for (int m = 1; m < 4; ++m) {
            hessian.block<3, 3>(0, 3 * m) -= hessian.block<3, 3>(3 * k, 3 * m);
            hessian.block<3, 3>(3 * k, 0) -= hessian.block<3, 3>(3 * k, 3 * m);
        }
    for (int k = 1; k < 4; ++k)
        hessian.block<3, 3>(0, 0) -= hessian.block<3, 3>(3 * k, 0);
    return hessian;
}

void add_block(std::vector<Eigen::Triplet<double>> &entries, const std::array<int, 4> &tetrahedron,
               const Eigen::Matrix<double, 12, 12> &block) {
    for (int row = 0; row < 12; ++row)
        for (int column = 0; column < 12; ++column)
            entries.emplace_back(3 * tetrahedron[row / 3] + row % 3, 3 * tetrahedron[column / 3] + column % 3,
                                 block(row, column));
}

} // namespace livermark::msm
