#pragma once

#include <Eigen/SparseCore>

#include <cstdint>
#include <vector>

#include "interactive/method.hpp"

namespace livermark::interactive {

/// End of Newton's method.
struct Minimum {
    Field positions; ///< shape (3, N) [m]
    bool converged = false;
    int iterations = 0;    ///< of Newton's method
    double residual = 0.0; ///< force out of balance at free nodes, over what is balanced [N/N]
    double press = 0.0;    ///< what f is multiplied by where Loads::press, else 1
};

/// Kinds of external forces.
enum class Loads : std::uint8_t {
    known,
    press ///< f . x stays as it is, and f is multiplied by what that takes
};

struct NewtonSettings {
    double tolerance = 1e-10; ///< of the residual
    int max_iterations = 200;
    Loads loads = Loads::known;
};

/// The least of
///     W(x) - f . x + sum over the nodes of k_i / 2 |x_i - y_i|^2
/// over the positions of the free nodes, by Newton's method with CHOLMOD. The second derivatives of elements are made
/// positive semidefinite where the whole is not positive definite; a step goes as far as the sum becomes less.
///
/// Under Loads::press it is the least of W among the positions with this f . x.
///
/// It shares nothing with the steps of methods but their energy, so that what these converge to can be checked.
///
/// @param forces   f, shape (3, N) [N]
/// @param inertia  k and y; nullptr for the static solution, k = 0
/// @param start    shape (3, N); constrained nodes stay where they are
Minimum minimise(const Energy &energy, const std::vector<bool> &is_free, const Field &forces, const Inertia *inertia,
                 const Field &start, const NewtonSettings &settings = {});

/// Positions of the free nodes when constrained nodes move and forces change, as far as the tangent at x knows.
/// @param x            shape (3, N), where the free nodes are in balance
/// @param moved_to     the same, with constrained nodes elsewhere
/// @param more_forces  shape (3, N) [N]
Field predict(const Energy &energy, const std::vector<bool> &is_free, const Field &x, const Field &moved_to,
              const Field &more_forces);

/// A static solution.
struct Equilibrium {
    Field positions;      ///< shape (3, N) [m], as far as the load went
    Field elastic_forces; ///< shape (3, N) [N]; minus these and the external forces is what constrained nodes need
    bool converged = false;
    double fraction = 0.0; ///< of the load that was reached, that which was wanted if converged
    int iterations = 0;    ///< of Newton's method, from the start of the path
    double load = 0.0;     ///< what the external forces were multiplied by: the fraction, or newtons where they press
};

/// Static solutions, to which a method comes when nothing limits its iterations: the least of its energy less the work
/// of the external forces, with the constrained nodes at their targets. Newton's method, along a path on which forces
/// and displacements of constrained nodes grow together; a load step that does not converge is taken again at half its
/// length.
/// @param simulation  with the forces and targets of the whole load; it stays as it is
/// @param fractions   of the load, ascending, > 0
/// @param press_depth  if not 0, the external forces are those of one newton, and are multiplied by what it takes until
///   the sum of their products with the displacements is this depth [m]; targets are where nodes are at rest then
/// @param foundation  that the body stands on, or null; its springs are among the elastic forces
/// @return one for each fraction; the last is not converged, and there are none behind it, where the path ended early
std::vector<Equilibrium> equilibria(const Simulation &simulation, const std::vector<double> &fractions,
                                    double tolerance = 1e-9, double press_depth = 0.0,
                                    const core::Foundation *foundation = nullptr);

/// Changes of velocities by an impulse on each of K places in a step of backward Euler, with the stiffness of the body
/// at rest:
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
