#pragma once

#include <Eigen/SparseCore>

#include "interactive/simulation.hpp"

namespace livermark::interactive {

/// What an impulse on each of K places changes velocities by in a step of backward Euler, with the stiffness of the
/// body at rest:
///     (M (1 + alpha h) + h^2 K)^-1 W^T,
/// K being the second derivatives of the energy. Rows of constrained nodes are zero.
/// @param at_rest    of a method without nodes of its own
/// @param time_step  h [s], > 0
/// @param weights    W, shape (K, N): the parts that nodes have of a force on a place
/// @return shape (3 N, 3 K) [1/kg]; component c of node i in row 3 i + c, of place k in column 3 k + c
/// @throws std::logic_error if the matrix is not positive definite
Eigen::MatrixXf place_response(const Simulation &at_rest, double time_step,
                               const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights);

/// The same of what a method does itself, from rest, in steps that need not have converged: how far nodes come in an
/// interval under a force that lasts, over the square of the interval and the force.
/// @param at_rest   of a method without nodes of its own; left somewhere else
/// @param interval  of all steps together [s], > 0
/// @param force     on a place, small enough that what it does is proportional to it [N]
/// @return shape (3 N, 3 K) [1/kg], as above
Eigen::MatrixXf observed_place_response(Simulation &at_rest, double interval, int steps, int iterations,
                                        const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights, double force);

} // namespace livermark::interactive
