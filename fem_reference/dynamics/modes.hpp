#pragma once

#include <span>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "fem_reference/linear/elastic_system.hpp"

namespace livermark::fem_reference {

/// Consistent mass of one component of displacement, M_ab = sum over t of rho_t times the integral of N_a N_b; the
/// other two components have the same. Its pattern has one entry for each 3 x 3 block of the stiffness.
/// @return (n, n) [kg]; the sum of all entries is the mass of the body
SymmetricMatrix consistent_mass(const core::Body &body, const ElasticSystem &system);

/// out = M x for all three components.
/// @param mass    shape (n, n), of one component
/// @param x, out  shape (3 n), unknown of node a and component i at 3 a + i
void multiply_mass(const SymmetricMatrix &mass, std::span<const double> x, std::span<double> out);

/// k K + m M
/// @param stiffness  shape (3 n, 3 n)
/// @param mass       shape (n, n), as consistent_mass gives it for this stiffness
/// @return shape (3 n, 3 n)
SymmetricMatrix combine(double k, SymmetricMatrix stiffness, double m, const SymmetricMatrix &mass);

/// a . b
double dot(std::span<const double> a, std::span<const double> b);

/// out += factor x
void add_scaled(double factor, std::span<const double> x, std::span<double> out);

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

/// Lowest modes of a body constrained where the load case prescribes displacements (at zero, whatever the value; its
/// loads do not count), with linear or quadratic elements and consistent mass. See lowest_eigenpairs for the method.
/// @param degree  1 or 2
/// @param count   at least 1
/// @throws support::InputError if the load case leaves the body free to move, or if it has fewer modes than that
/// @throws std::invalid_argument for another degree, or a load case of another mesh
core::Modes lowest_modes(const core::Problem &problem, int degree, int count);

} // namespace livermark::fem_reference
