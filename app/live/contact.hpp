#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "core/load_case.hpp"
#include "core/problem.hpp"
#include "core/tool/ball_contact.hpp"

namespace livermark::live {

/// Surface of a body that can be touched: boundary triangles that are not constrained.
struct Surface {
    std::vector<std::array<int, 3>> triangles; ///< (L) node numbers of the mesh, right-handed seen from outside
    std::vector<int> facet;                    ///< (L) which boundary triangles of the mesh these are
    std::vector<double> area;                  ///< (L) at rest [m^2]
    std::vector<int> nodes;                    ///< of these triangles, each once, ascending
};

/// @param is_constrained  shape (T), which boundary triangles cannot move
Surface touchable_surface(const core::TetraMesh &mesh, const std::vector<bool> &is_constrained);

/// Forces of a tool on a body.
struct Load {
    std::vector<int> nodes{};                    ///< (K) that are loaded, each once
    std::vector<core::Vector3> nodal{};          ///< (K) forces on these [N]
    std::vector<int> triangles{};                ///< (L) of the surface that are loaded, each once
    std::vector<core::Vector3> facet{};          ///< (L) forces on these [N]
    core::Vector3 total = core::Vector3::Zero(); ///< [N]
    /// Spread of the force of a pull, with the resultant `total`; radius 0 where it is even on each triangle.
    core::RoundLoad shape;
};

/// Between the target, which jumps as a hand and a mouse do, and the body there is a small mass on a damped spring
/// (virtual coupling, Colgate, Stanley, Brown 1995, IROS): however rough the hand, what reaches the body is slow and
/// not stronger than the limit.
struct Proxy {
    core::Vector3 position = core::Vector3::Zero(); ///< [m]
    core::Vector3 velocity = core::Vector3::Zero(); ///< [m/s]
    core::Vector3 target = core::Vector3::Zero();   ///< where it is drawn to now [m]
};

/// Numbers of the virtual coupling: a metal probe that lies loosely in the hand.
inline constexpr double coupling_mass = 0.05;       ///< [kg]
inline constexpr double coupling_stiffness = 400.0; ///< [N/m]
inline constexpr double strongest_coupling = 12.0;  ///< [N]
inline constexpr double fastest_target = 0.5;       ///< [m/s]

/// Moves the target on, no faster than it may go.
void follow(Proxy &proxy, const core::Vector3 &target, double time_step);

/// One step of symplectic Euler.
/// @param force  of the body on the proxy [N]
void advance(Proxy &proxy, const core::Vector3 &force, double time_step);

/// Position of a node now, or another vector of it [m].
using PositionOf = std::function<core::Vector3(int node)>;

/// A point of the surface at rest.
struct Place {
    core::Vector3 point = core::Vector3::Zero();    ///< [m]
    core::Vector3 outwards = core::Vector3::Zero(); ///< normal of the surface there, of any length
    int triangle = -1;                              ///< of the surface, that the point is in
};

/// Place that a pull has hold of: forces are spread over it as those of the round tools of load cases
/// (core/load_case.hpp), so that a pull of one radius means the same on any mesh, and where it is now is the mean
/// with the same weights.
struct Disc {
    Place place;                ///< its middle
    core::RoundLoad shape;      ///< around that
    std::vector<int> triangles; ///< of the surface that it reaches, and that face the way of its middle
    std::vector<double> share;  ///< what each takes of a force on the disc; they add up to one
    std::vector<int> nodes;     ///< of these triangles, each once
    std::vector<double> weight; ///< what each takes, by linear shape functions; they add up to one
};

/// @param points  shape (N), at rest [m]
Place place_of_node(const Surface &surface, const std::vector<core::Vector3> &points, int node);

/// @param points  shape (N), at rest [m]
/// @return on the triangle of the place alone where it is too small for the mesh to be seen
Disc disc_around(const Surface &surface, const std::vector<core::Vector3> &points, const Place &place, double radius);

/// Mean of a nodal field over a disc.
core::Vector3 mean_over(const Disc &disc, const PositionOf &field);

/// Load of a force on a disc.
Load load_of(const Disc &disc, const core::Vector3 &force);

/// Body as a ball may touch it.
struct TouchableBody {
    core::Body body;                          ///< of the material that moves
    core::LoadCase load_case;                 ///< that constrains what cannot be touched
    std::vector<core::TouchedFacet> facets{}; ///< those of touchable_surface(), in its order
};

/// @param mesh            of what is left of the body
/// @param is_constrained  shape (T) of that
TouchableBody touchable_body(const core::TetraMesh &mesh, const std::vector<core::Material> &materials,
                             const std::vector<bool> &is_constrained);

/// A rigid ball that touches the surface with friction, by the law of load cases and of the arena (core::BallContact).
/// A hand comes from outside: put down in the body it begins on the surface. Where its centre gets below the surface it
/// touches nothing until it is nearly out again.
struct HeldBall {
    std::shared_ptr<core::BallContact> contact; ///< takes part in steps; null where there is no ball
    double radius = 0.0;                        ///< [m]
    int steps_to_look = 0;                      ///< until facets around it are looked for again
    bool is_below = false;                      ///< whether its centre is below the surface

    core::Vector3 force() const { return contact->force(); } ///< on the body in the last step [N]
    /// One of its own that goes on in the same way.
    HeldBall copy() const;
};

HeldBall take_ball(const TouchableBody &touchable, double radius, double friction);

/// Place for the centre of a ball where it does not reach into the body, near the one that was asked for [m].
core::Vector3 outside(const Surface &surface, double radius, const core::Vector3 &centre,
                      const PositionOf &position_of);

/// Leads the ball with the proxy in the step to come.
/// @param from         where its centre was [m]
/// @param position_of  of nodes now [m]
void lead(HeldBall &ball, const Surface &surface, const Proxy &proxy, const core::Vector3 &from, double time_step,
          const PositionOf &position_of);

/// Forces of the ball in the last step.
Load load_of(const HeldBall &ball, const Surface &surface);

} // namespace livermark::live
