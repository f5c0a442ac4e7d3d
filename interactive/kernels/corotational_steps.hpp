#pragma once

#include <array>
#include <vector>

#include "interactive/kernels/explicit_steps.hpp"

namespace livermark::interactive::kernels {

/// Numbers of the rotation of a tetrahedron: a unit quaternion w, x, y, z.
inline constexpr std::size_t numbers_of_rotation = 4;

/// A spring between three nodes and a ball that touches them (ImplicitContact::Point).
struct TouchedRows {
    std::array<int, 3> rows{};
    std::array<float, 3> shape{};
    std::array<float, 6> stiffness{}; ///< xx, xy, xz, yy, yz, zz [N/m]
    std::array<float, 3> force{};     ///< where the step begins [N]
};

/// A body of co-rotational tetrahedra, its state, and what conjugate gradients need, in single precision. Fans, slots
/// and nodes are those of explicit elements. The stiffness is that of linear elasticity with the gradients of shape
/// functions turned by R, so these are what an iteration reads of a tetrahedron.
struct CorotationalRows {
    ExplicitRows body;
    Aligned<float> turned;   ///< as body.tetrahedra, with turned gradients
    Aligned<float> rotation; ///< lines of tetrahedra, numbers_of_rotation vectors of 16 for each; from step to step
    /// As body.force: xx, xy, xz and yy, yz, zz of V (lambda + mu) g g^T with turned gradients [N/m].
    std::array<Aligned<float>, 2> block_slots;
    // Rows of four, the last one zero but where it says so.
    std::array<Aligned<float>, 2> block; ///< sums of slots at nodes
    Aligned<float> mass;                 ///< [kg], three times the same, and the sum of V mu |g|^2 [N/m]
    Aligned<float> residual, direction, product, preconditioned;
    Aligned<float> inverse_block; ///< slices of nodes, xx, xy, xz, yy, yz, zz of each [1/kg]; zero where constrained

    std::vector<TouchedRows> touched; ///< of the step to come

    std::size_t bytes() const; ///< of the body and its state
};

/// @param scene  without nodes of a method's own
CorotationalRows corotational_rows(const Scene &scene);

/// The rotation next to a deformation gradient, whatever it is, in double precision.
/// @param h  F - 1 by columns
/// @param q  quaternion w, x, y, z; stays as it is if there are no numbers in h
void find_nearest_rotation(const std::array<float, 9> &h, std::array<float, 4> &q);

/// A linearised step of backward Euler as CorotationalImplicit takes it, in single precision on the vectors of the
/// machine: rotations, and conjugate gradients from the velocities with the blocks of nodes as preconditioner.
/// Constrained nodes keep their velocities. Points that are touched take part as springs.
/// @param time_step     h [s]
/// @param mass_damping  alpha [1/s]
/// @param iterations    of conjugate gradients, fewer where nothing is left to do
void take_corotational_step(CorotationalRows &rows, double time_step, double mass_damping, int iterations);

} // namespace livermark::interactive::kernels
