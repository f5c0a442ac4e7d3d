#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "msm/kernels/layout/sliced_body.hpp"

/// What selective mass scaling (msm/dynamics/mass_scaling.hpp) asks of vector units.
namespace livermark::msm {

/// A part whose masses are scaled, one component behind the other, each filled up to whole slices by nodes without
/// mass. Positions are from any point near the part: float has too few digits for those of a body.
template <class T> struct ScaledMassArrays {
    std::size_t size = 0;     ///< of a component, n and what fills it up
    std::size_t num_slow = 0; ///< m
    Aligned<T> mass;          ///< (size) [kg]
    Aligned<T> rest;          ///< (3, size) [m]
    Aligned<T> slow;          ///< (m, 3, size) deformations that are left alone [kg^-1/2]
    Aligned<T> x;             ///< (3, size) where a step starts [m]; after strays(), from the centre of mass
    Aligned<T> v;             ///< (3, size) there [m/s]
    Aligned<T> a;             ///< (3, size) M^-1 F [m/s^2]
    Aligned<T> stray;         ///< (3, size) what of these is to be scaled [m/s^2]
};

/// Sums over the nodes of a part; a moment of two fields is sum of m p q^T.
struct ScaledMassSums {
    core::Vector3 of_x, of_v, of_a;               ///< sums of m x, m v, m a
    Eigen::Matrix3d x_and_x, x_and_rest, x_and_v; ///< moments
    core::Vector3 x_cross_a;                      ///< sum of m x x a
};

template <class T> ScaledMassSums scaled_mass_sums(const ScaledMassArrays<T> &part);

/// The rigid motion of a part, and the rigid part of its accelerations less those of turning.
struct ScaledMassMotion {
    core::Vector3 centre;                ///< of mass, from where x is from [m]
    core::Vector3 velocity, rotation;    ///< [m/s], [rad/s]
    core::Vector3 acceleration, spin_up; ///< [m/s^2], [rad/s^2]
    Eigen::Matrix3d turn;                ///< since rest
};

/// Moves x to the centre of mass, and puts into stray what a is besides a rigid motion and turning,
///   a - w x (2 (v - v_c) - w x x) - a_c - w' x x.
/// @param weights  (m) sum of m slow_k . turn^T stray of each slow deformation
template <class T>
void find_strays(ScaledMassArrays<T> &part, const ScaledMassMotion &motion, std::vector<double> &weights);

/// What slow deformations have of momentum.
struct SlowMomenta {
    core::Vector3 linear, angular; ///< sums of m e and m x x e
};

/// Takes e = turn (sum of weight_k slow_k) off stray.
template <class T>
SlowMomenta subtract_slow(ScaledMassArrays<T> &part, const Eigen::Matrix3d &turn, const std::vector<double> &weights);

} // namespace livermark::msm
