#pragma once

#include <span>

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

} // namespace livermark::fem_reference
