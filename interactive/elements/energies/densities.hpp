#pragma once

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "interactive/elements/tetrahedra.hpp"

/// Energies per volume of a deformation gradient F: their value [Pa], the stress P = dW/dF [Pa], and the tangent dP/dF,
/// shape (9, 9), of F by columns.
namespace livermark::interactive::densities {

using Tangent = Eigen::Matrix<double, 9, 9>;

inline Eigen::Matrix<double, 9, 1> by_columns(const Matrix3 &a) {
    return Eigen::Map<const Eigen::Matrix<double, 9, 1>>(a.data());
}

/// d2 det F / dF2.
Tangent determinant_tangent(const Matrix3 &f);

/// The same tangent with its negative eigenvalues at zero.
Tangent semi_definite_part(const Tangent &tangent);

/// The rotation R of F = R S, that of the polar decomposition unless det F < 0: then the nearest one.
Matrix3 nearest_rotation(const Matrix3 &f);

/// The same by Newton's iteration R <- (R + R^-T) / 2 from R = F, which is quicker; what is flat or inside out is left
/// to the singular values.
/// (Higham 1986, SIAM J. Sci. Stat. Comput. 7(4))
inline Matrix3 rotation(const Matrix3 &f) {
    constexpr double tolerance = 1e-16; // of the square of a change; the next one changes its square
    constexpr int max_iterations = 12;
    if (f.determinant() > 0.05) {
        Matrix3 r = f;
        for (int i = 0; i < max_iterations; ++i) {
            const Matrix3 next = 0.5 * (r + cofactors(r) / r.determinant());
            const double change = (next - r).squaredNorm();
            r = next;
            if (change < tolerance)
                return r;
        }
    }
    return nearest_rotation(f);
}

/// W = mu |F - R|^2 + lambda / 2 tr(R^T F - 1)^2, whose forces are -R K (R^T x - x_0) with K the stiffness of linear
/// elasticity.
/// (Mueller, Gross 2004, Interactive virtual materials, Graphics Interface)
struct Corotational {
    double mu, lambda;

    double value(const Matrix3 &f) const {
        const Matrix3 r = rotation(f);
        const double trace = r.cwiseProduct(f).sum() - 3.0;
        return mu * (f - r).squaredNorm() + 0.5 * lambda * trace * trace;
    }
    Matrix3 stress(const Matrix3 &f) const { return stress(f, rotation(f)); }
    Matrix3 stress(const Matrix3 &f, const Matrix3 &r) const {
        return 2.0 * mu * (f - r) + lambda * (r.cwiseProduct(f).sum() - 3.0) * r;
    }
    /// dR = R [w], (tr S - S) w = axial vector of R^T dF.
    Tangent tangent(const Matrix3 &f) const;
};

/// W = mu / 2 (I1 - 3 - 2 ln J) + lambda / 2 (ln J)^2, infinite where J <= 0.
/// (Bonet, Wood 2008, Nonlinear Continuum Mechanics for Finite Element Analysis, eq. 6.27)
struct NeoHookean {
    double mu, lambda;

    double value(const Matrix3 &f) const {
        const double jacobian = f.determinant();
        if (!(jacobian > 0.0))
            return std::numeric_limits<double>::infinity();
        const double log = std::log(jacobian);
        return 0.5 * mu * (f.squaredNorm() - 3.0 - 2.0 * log) + 0.5 * lambda * log * log;
    }
    Matrix3 stress(const Matrix3 &f) const {
        const double jacobian = f.determinant();
        return mu * f + (lambda * std::log(jacobian) - mu) / jacobian * cofactors(f);
    }
    Tangent tangent(const Matrix3 &f) const;
};

/// W = mu / 2 (I1 - 3) - mu (J - 1) + (lambda + mu) / 2 (J - 1)^2, which goes through J = 0. The volume term has
/// lambda + mu, not lambda, so that small strains have the Lame parameters of the material.
/// (Smith, De Goes, Kim 2018, Stable neo-Hookean flesh simulation, ACM TOG 37(2), without its logarithm)
struct StableNeoHookean {
    double mu, lambda;

    double value(const Matrix3 &f) const {
        const double growth = f.determinant() - 1.0;
        return 0.5 * mu * (f.squaredNorm() - 3.0) - mu * growth + 0.5 * (lambda + mu) * growth * growth;
    }
    Matrix3 stress(const Matrix3 &f) const {
        return mu * f + ((lambda + mu) * (f.determinant() - 1.0) - mu) * cofactors(f);
    }
    Tangent tangent(const Matrix3 &f) const;
};

} // namespace livermark::interactive::densities
