#pragma once

#include <vector>

#include "core/modes.hpp"
#include "core/solution.hpp"
#include "msm/nodal_conditions.hpp"
#include "msm/spring_law.hpp"

/// Free vibrations of springs linearised at rest, K phi = omega^2 M phi with K = sum over springs of k b b^T, where b
/// is the direction n of the spring at one end and -n at the other, and M the node masses. What is prescribed is held
/// at zero, whatever its value; loads do not count.
namespace livermark::msm {

/// The lowest modes of a body under a spring law, held as in the load case.
/// @param count  at least 1
/// @throws core::InputError if the load case leaves the body free to move, or if it has fewer modes than that
core::Modes lowest_modes(const core::Problem &problem, const SpringLaw &law, int count);

/// The lowest modes by shift-invert about zero: Lanczos's method with implicit restarts (Spectra) for the largest
/// eigenvalues 1 / omega^2 of the inverse of M^-1/2 K M^-1/2, with one sparse Cholesky factor of it.
/// @param springs     masses > 0, at rest at the positions
/// @param positions   shape (N) [m]
/// @param conditions  of the nodes
/// @param count       at least 1
/// @return shapes of M-norm 1 with their largest entry positive
/// @throws core::InputError if what is held leaves the springs free to move, or if they have fewer modes than that
/// @throws std::runtime_error if the iteration does not converge
core::Modes lowest_modes(const core::SpringNetwork &springs, const std::vector<core::Vector3> &positions,
                         const NodalConditions &conditions, int count);

/// The largest omega, which sets the critical time step of every explicit integrator, to a relative accuracy of 1e-9:
/// Lanczos's method on M^-1/2 K M^-1/2 applied spring by spring, without a matrix. The springs may be free to move, and
/// the same springs give the same bits.
/// @param springs     masses > 0, at rest at the positions
/// @param positions   shape (N) [m]
/// @param conditions  of the nodes
/// @return [rad/s]; zero if nothing can move
/// @throws std::runtime_error if the iteration does not converge
double largest_angular_frequency(const core::SpringNetwork &springs, const std::vector<core::Vector3> &positions,
                                 const NodalConditions &conditions);

/// A bound on the largest omega from above for the price of one pass over the springs: Gershgorin's, with the 3 x 3
/// block of each node in place of a row,
///   omega^2 <= 2 max_i lambda_max(K_ii) / m_i,   K_ii = sum over the springs at node i of k n n^T,
/// because (n . (x_i - x_j))^2 <= 2 (n . x_i)^2 + 2 (n . x_j)^2 makes x^T K x <= 2 sum_i x_i^T K_ii x_i. It knows in
/// which directions the springs of a node pull, and is never above 2 max_i (sum_j k_ij) / m_i. K_ii is taken over the
/// free components of the node.
/// @param springs     masses > 0, at rest at the positions
/// @param positions   shape (N) [m]
/// @param conditions  of the nodes
/// @return [rad/s]; zero if nothing can move
double gershgorin_angular_frequency(const core::SpringNetwork &springs, const std::vector<core::Vector3> &positions,
                                    const NodalConditions &conditions);

} // namespace livermark::msm
