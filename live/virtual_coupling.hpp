#pragma once

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::live {

/// Between the target, which jumps as a hand and a mouse do, and the body there is a small mass on a damped spring
/// (virtual coupling, Colgate, Stanley, Brown 1995, IROS): however rough the hand, what reaches the body is slow and
/// not stronger than the limit.
struct Proxy {
    core::Vector3 position = core::Vector3::Zero(); ///< [m]
    core::Vector3 velocity = core::Vector3::Zero(); ///< [m/s]
    core::Vector3 target = core::Vector3::Zero();   ///< where it is drawn to now [m]
};

/// Of the virtual coupling. A metal probe that lies loosely in the hand.
inline constexpr double coupling_mass = 0.05;       ///< [kg]
inline constexpr double coupling_stiffness = 400.0; ///< [N/m]
inline constexpr double strongest_coupling = 12.0;  ///< [N]
inline constexpr double fastest_target = 0.5;       ///< [m/s]

/// Moves the target on, no faster than it may go.
void follow(Proxy &proxy, const core::Vector3 &target, double time_step);

/// One step of symplectic Euler.
/// @param force  of the body on the proxy [N]
void advance(Proxy &proxy, const core::Vector3 &force, double time_step);

} // namespace livermark::live
