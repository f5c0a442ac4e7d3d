#include "fem_reference/hyperelastic/surface/surface_impedance.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

namespace livermark::hyperelastic {

namespace {

using Vector3 = Eigen::Vector3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// The matrix C_iJjL a_J b_L.
Matrix3 acoustic(const Tangent &tangent, const Vector3 &a, const Vector3 &b) {
    Matrix3 result = Matrix3::Zero();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                for (int l = 0; l < 3; ++l)
                    result(i, j) += tangent(3 * i + k, 3 * j + l) * a[k] * b[l];
    return result;
}

/// [S, H; -L, S^T] of Barnett and Lothe: the square root of -1 that has the invariant subspaces of a real matrix
/// without real eigenvalues, by Newton's method for the sign of a matrix.
/// @return not finite where there is none
Matrix6 root_of_minus_one(Matrix6 matrix) {
    constexpr int most_iterations = 40;
    constexpr double tolerance = 1e-11;
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
        const Matrix6 next = 0.5 * (matrix - matrix.inverse());
        const double change = (next - matrix).norm();
        matrix = next;
        if (!(change > tolerance * matrix.norm()))
            return matrix;
    }
    return Matrix6::Constant(std::numeric_limits<double>::quiet_NaN());
}

/// Of waves along one direction, of moduli over their size.
double least_eigenvalue(const Tangent &tangent, const Vector3 &along, const Vector3 &inwards) {
    const Matrix3 q = acoustic(tangent, along, along), r = acoustic(tangent, along, inwards);
    const Matrix3 inverse = acoustic(tangent, inwards, inwards).inverse();
    Matrix6 stroh; // A. N. Stroh 1962, Steady state problems in anisotropic elasticity, J. Math. Phys. 41
    stroh << -inverse * r.transpose(), inverse, r * inverse * r.transpose() - q, -r * inverse;
    const Matrix6 root = root_of_minus_one(stroh);
    if (!root.allFinite())
        return std::numeric_limits<double>::quiet_NaN();
    const Matrix3 inverse_h = root.topRightCorner<3, 3>().inverse();
    Eigen::Matrix3cd impedance;
    impedance.real() = inverse_h;
    impedance.imag() = inverse_h * root.topLeftCorner<3, 3>();
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3cd>(impedance, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

} // namespace

Matrix3 whole_stress(const MaterialLaw &law, const core::Material &material, const Matrix3 &f) {
    const double jacobian = f.determinant();
    const auto volume = law.volume(jacobian);
    return law.stress(material, f) +
           law.volume_modulus(material) * volume.value * volume.slope * jacobian * f.inverse().transpose();
}

Tangent whole_tangent(const MaterialLaw &law, const core::Material &material, const Matrix3 &f) {
    const double jacobian = f.determinant(), modulus = law.volume_modulus(material);
    const auto volume = law.volume(jacobian);
    auto tangent = law.tangent(material, f);
    add_volume_tangent(modulus * volume.value * volume.slope,
                       modulus * (volume.slope * volume.slope + volume.value * volume.curvature), jacobian, f.inverse(),
                       tangent);
    return tangent;
}

void add_follower_pressure(double pressure, const Matrix3 &f, Tangent &tangent) {
    add_volume_tangent(pressure, 0.0, f.determinant(), f.inverse(), tangent);
}

double least_surface_impedance(const Tangent &tangent, const Vector3 &normal) {
    constexpr int num_directions = 12;
    const double size = tangent.diagonal().cwiseAbs().maxCoeff();
    const Vector3 first = normal.unitOrthogonal(), second = normal.cross(first);
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < num_directions; ++k) {
        const double angle = std::numbers::pi * k / num_directions; // -t has the conjugate impedance
        const double here =
            least_eigenvalue(tangent / size, std::cos(angle) * first + std::sin(angle) * second, -normal);
        if (!(here >= least))
            least = here;
        if (std::isnan(least))
            break;
    }
    return size * least;
}

} // namespace livermark::hyperelastic
