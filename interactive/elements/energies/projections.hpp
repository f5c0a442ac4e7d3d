#pragma once

#include "interactive/elements/energies/densities.hpp"

namespace livermark::interactive::densities {

/// F = U diag(s) V^T with rotations U and V; the last of s is negative where det F is.
struct SignedSvd {
    Matrix3 u, v;
    core::Vector3 s;
};

SignedSvd signed_svd(const Matrix3 &f);

/// The point nearest to s whose components have the product one.
/// (Bouaziz et al. 2014, appendix A)
core::Vector3 nearest_of_unit_product(const core::Vector3 &s);

/// W = mu |F - R|^2 + 3 lambda / 2 |F - D|^2, with R the nearest rotation and D the nearest matrix of determinant one:
/// at small strains mu |eps|^2 + lambda / 2 (tr eps)^2, because |F - D|^2 is (tr eps)^2 / 3 there.
/// (Bouaziz et al. 2014, sections 5.1 and 5.2, with the weights 2 mu V and 3 lambda V)
struct Projective {
    double mu, lambda;

    double weight() const { return 2.0 * mu + 3.0 * lambda; } ///< of both
    double value(const Matrix3 &f) const;
    Matrix3 stress(const Matrix3 &f) const;
    Tangent tangent(const Matrix3 &f) const;
};

} // namespace livermark::interactive::densities
