#pragma once

#include <Eigen/Core>
#include <vector>

#include "msm/dynamics/mass_scaling.hpp"
#include "msm/elastic_body.hpp"
#include "msm/nodal_conditions.hpp"
#include "msm/statics/free_components.hpp"

/// What limits explicit steps: the highest frequency of a body linearised at rest, K phi = omega^2 M phi with K the
/// material tangent and M the node masses. What is prescribed is constrained at zero, whatever its value; loads do not
/// count.
namespace livermark::msm {

/// The largest omega, which sets the critical time step of every explicit integrator, to a relative accuracy of 1e-9 if
/// no other is asked for:
/// Lanczos's method on M^-1/2 K M^-1/2 applied term by term, without a matrix. The body may be free to move, and the
/// same body gives the same bits.
/// @param body        masses > 0, at rest at the positions
/// @param positions   shape (N) [m]
/// @param conditions  of the nodes
/// @param scaling     of the masses
/// @param tolerance   of omega^2, as a part of it
/// @return [rad/s]; zero if nothing can move
/// @throws std::runtime_error if the iteration does not converge
double largest_angular_frequency(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                                 const NodalConditions &conditions, const MassScaling &scaling = {},
                                 double tolerance = 1e-9);

/// The mode of the largest omega.
struct HighestMode {
    double angular_frequency = 0.0; ///< [rad/s]
    Eigen::VectorXd shape;          ///< (3N) M^1/2 phi, of length 1; zero where constrained
    FreeComponents free{{}};
};

/// @throws std::runtime_error if the iteration does not converge
HighestMode highest_mode(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                         const NodalConditions &conditions);

/// The largest omega by the highest mode of the same body where it is constrained less, for bodies that are constrained
/// here and there one after the other. What holds more has no frequency above it (Cauchy's interlacing), and none of
/// its largest is below the Rayleigh quotient of any trial vector: a mode that hardly reaches what is constrained
/// beside leaves nothing between both, which a single product shows. Otherwise Lanczos's method looks for another one.
/// @param of_less  of the same body; Lanczos's method is taken as well where that holds something else
double largest_angular_frequency(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                                 const NodalConditions &conditions, const HighestMode &of_less);

/// A bound on the largest omega from above for the price of one pass over the terms: Gershgorin's, with the 3 x 3 block
/// of each node in place of a row,
///   omega^2 <= max_i lambda_max(B_ii) / m_i   because   u^T K u <= sum over nodes of u_i^T B_ii u_i,
/// with the blocks of ElasticTerm::add_block_bound(). Those of springs are 2 sum over the springs at node i of k n n^T;
/// they know in which directions the springs of a node pull, and the bound is never above 2 max_i (sum_j k_ij) / m_i.
/// B_ii is taken over the free components of the node.
/// @param body        masses > 0, at rest at the positions
/// @param positions   shape (N) [m]
/// @param conditions  of the nodes
/// @return [rad/s]; zero if nothing can move
double gershgorin_angular_frequency(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                                    const NodalConditions &conditions);

/// The same bound node by node, (lambda_max(B_ii) / m_i)^1/2: which nodes ask for short steps.
/// @return shape (N) [rad/s]; zero where nothing can move
std::vector<double> nodal_frequency_bounds(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                                           const NodalConditions &conditions);

} // namespace livermark::msm
