#pragma once

#include <array>
#include <functional>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/tool/round_load.hpp"

namespace livermark::live {

/// What of a body can be touched: boundary triangles that are not constrained.
struct Surface {
    std::vector<std::array<int, 3>> triangles; ///< (L) node numbers of the mesh, right-handed seen from outside
    std::vector<int> facet;                    ///< (L) which boundary triangles of the mesh these are
    std::vector<double> area;                  ///< (L) at rest [m^2]
    std::vector<int> nodes;                    ///< of these triangles, each once, ascending
    std::vector<double> nodal_area;            ///< (N) a third of the triangles around each node of the mesh [m^2]
};

/// @param is_constrained  shape (T), which boundary triangles cannot move
Surface touchable_surface(const core::TetraMesh &mesh, const std::vector<bool> &is_constrained);

/// Forces of a tool on a body.
struct Load {
    std::vector<core::Vector3> nodal;            ///< (N) [N]; zero but at the nodes
    std::vector<int> nodes;                      ///< that may be loaded, each once
    std::vector<core::Vector3> facet;            ///< (L) of each triangle of the surface [N]; zero but at the triangles
    std::vector<int> triangles;                  ///< that are loaded, each once
    core::Vector3 total = core::Vector3::Zero(); ///< [N]
    /// How the force is spread, with the resultant `total`; looked at where there are triangles alone.
    core::RoundLoad shape;
};

/// No load on anything.
Load no_load(const Surface &surface);

/// Takes the forces off.
void clear(Load &load);

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

/// How a tool touches the surface: over a disc, as the round tools of load cases do, so that a tool of one radius means
/// the same here and there, and on any mesh.

/// A rigid sphere without friction.
struct Sphere {
    core::Vector3 centre = core::Vector3::Zero(); ///< [m]
    double radius = 0.0;                          ///< [m]
};

/// Where a node is now, or what else a node has [m].
using PositionOf = std::function<core::Vector3(int node)>;

/// A point of the surface at rest.
struct Place {
    core::Vector3 point = core::Vector3::Zero();    ///< [m]
    core::Vector3 outwards = core::Vector3::Zero(); ///< normal of the surface there, of any length
    int triangle = -1;                              ///< of the surface, that the point is in
};

/// What a tool touches: forces are spread over it as a round load is (core/tool/round_load.hpp), and where it is now is
/// the mean with the same weights.
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

/// Triangles that a disc of this radius can reach whose middle is no further than the margin from a point, all at rest.
std::vector<int> triangles_around(const Surface &surface, const std::vector<core::Vector3> &points,
                                  const core::Vector3 &point, double radius, double margin);

/// @param near  triangles, of triangles_around()
/// @return on the triangle of the place alone where it is too small for the mesh to be seen
Disc disc_around(const Surface &surface, const std::vector<core::Vector3> &points, const std::vector<int> &near,
                 const Place &place, double radius);

/// Mean of a nodal field over a disc.
core::Vector3 mean_over(const Disc &disc, const PositionOf &field);

/// Mean outward unit normal of the surface over a disc, weighted with the round load.
core::Vector3 mean_normal(const Disc &disc, const Surface &surface, const PositionOf &position_of);

/// Puts a force on a disc, in place of what was loaded before.
void put_force(const Disc &disc, const core::Vector3 &force, Load &load);

/// A sphere that touches one place of the surface. While it touches, the disc goes along with it and towards the place
/// under it, where the sphere's centre c is straight above x = m + u along the normal of the disc at rest, m being its
/// middle and u its mean displacement. Where it does not touch, m is the nearest point of the surface as it is now.
struct SphereContact {
    Disc disc;
    std::vector<int> near;                             ///< see triangles_around()
    core::Vector3 near_point = core::Vector3::Zero();  ///< around which these are [m]
    core::Vector3 last_centre = core::Vector3::Zero(); ///< of the sphere, if it touches [m]
    bool touches = false;
    double first_depth = 0.0; ///< how deep it was in the surface if it was put down in it [m]
    double time = 0.0;        ///< since the touch began [s]
    int num_misses = 0;       ///< how often it has not touched since it was taken up
};

/// Moves the disc on, as far as the sphere has moved along it and towards the place under it, and tells how deep the
/// sphere is in the surface.
/// @param tracking  part of the way to the place under the sphere that the disc goes at once, at most 1/2
/// @param displacement_of  of nodes now [m]
/// @return how far the sphere reaches below x along the normal of the disc at rest, against that [m]: with a stiffness
/// as a factor, the force of the sphere on the body, and the gradient of an energy of the displacement while the disc
/// stays under the sphere. It is zero where the sphere does not touch. A touch begins where the sphere is shallow in
/// the surface, or is put down with its centre above it.
core::Vector3 penetration(SphereContact &contact, const Surface &surface, const std::vector<core::Vector3> &points,
                          const Sphere &sphere, double tracking, const PositionOf &displacement_of);

} // namespace livermark::live
