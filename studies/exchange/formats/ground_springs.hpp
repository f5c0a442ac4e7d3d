#pragma once

#include <array>
#include <vector>

#include "studies/exchange/formats/export_format.hpp"

namespace livermark::exchange {

/// Component of the displacement of a node of a Discretisation, times a factor.
struct DisplacementTerm {
    int node = 0;
    int component = 0; ///< 0, 1 or 2
    double factor = 0.0;
};

/// Spring of 1 N/m from the origin to a node that no element has: a form in which finite element programs have what
/// acts inside elements and on facets, by linear constraints. Its energy is (|rest + w| - |rest|)^2 / 2 J, w the
/// displacement of the node.
struct GroundSpring {
    core::Vector3 rest; ///< where the node is at rest [m], not zero
    /// w_x, w_y and w_z are the sums of these; without any the component is zero.
    std::array<std::vector<DisplacementTerm>, 3> displacement;
};

/// The vessels and the foundation of a problem.
///
/// Fibre of a vessel in a linear element: the spring of core::vessel_springs, its ends at x and y, is
/// rest = sqrt k (y - x), w = sqrt k (u(y) - u(x)).
///
/// Foundation on a facet: the integral M_ab of N_a N_b over it is L L^T by Cholesky, so k / 2 of the integral of a
/// component squared is the sum over the columns of L of (sqrt k sum_a L_aj u_a)^2 / 2. Each square is a spring along
/// x, so long that nothing turns it round.
/// @param fem  of the body; linear where it has vessels
std::vector<GroundSpring> ground_springs(const core::Problem &problem, const Discretisation &fem);

/// The same as arrays.
struct SpringTable {
    explicit SpringTable(const std::vector<GroundSpring> &springs);

    std::vector<core::Vector3> rest; ///< (G)
    /// (K) spring, component of its node, and the node and component of the body
    std::vector<std::array<int, 4>> terms;
    std::vector<double> factor; ///< (K)
};

} // namespace livermark::exchange
