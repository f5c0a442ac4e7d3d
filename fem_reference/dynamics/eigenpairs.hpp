#pragma once

#include <span>
#include <vector>

#include "fem_reference/linear/elastic_system.hpp"

namespace livermark::fem_reference {

/// The lowest solutions of K phi = omega^2 M phi.
struct EigenPairs {
    std::vector<double> angular_frequency;  ///< (C) omega [rad/s], ascending
    std::vector<std::vector<double>> shape; ///< (C)(3 n) phi [kg^-1/2]: phi^T M phi = 1, its largest entry positive
};

/// Finds them by shift-invert about zero: Lanczos's method with implicit restarts (Spectra) for the largest eigenvalues
/// 1 / omega^2 of K^-1 M in the inner product of M, where one sparse Cholesky factor of K serves all iterations.
/// @param stiffness   shape (3 n, 3 n) [N/m]
/// @param mass        shape (n, n) [kg], of one component
/// @param prescribed  shape (3 n), NaN where an unknown is free; the others are constrained at zero, whatever their
/// value
/// @param count       how many, at least 1
/// @throws support::InputError if what is constrained leaves the body free to move, or if it has fewer modes than that
/// @throws std::runtime_error if the iteration does not converge
EigenPairs lowest_eigenpairs(const SymmetricMatrix &stiffness, const SymmetricMatrix &mass,
                             std::span<const double> prescribed, int count);

} // namespace livermark::fem_reference
