#pragma once

#include <memory>
#include <span>
#include <string>

#include "app/live/scene.hpp"

/// Messages of the live page to a scene, and replies, as numbers in a row: the same to the kernel in the page
/// and to the one behind a socket. Numbers are float64, little-endian; so are the integers among them.
namespace livermark::live {

/// A body with what is constrained of it:
///   N, M, R, T, points (N,3) [m], tetrahedra (M,4), region (M), density (R) [kg/m^3], Young's modulus (R) [Pa],
///   Poisson's ratio (R), boundary triangles (T,3), constrained (T) 0 or 1,
///   map of stiffness: 0, or M and factors of moduli (M),
///   capsule: 0, or 1, thickness [m], Young's modulus [Pa], covered (T) 0 or 1,
///   vessels: 0, or V, W, points (V,3) [m], radius (V) [m], segments (W,2), wall ratio, wall modulus [Pa],
///   foundation: 0, or F, facets (F) ascending, stiffness (F) [N/m^3], along the normal alone (F) 0 or 1
/// @throws support::InputError if it is not that, or for what Scene refuses
std::unique_ptr<Scene> scene_of(std::span<const double> message);

/// Replies to one message by its first number.
///
///     1, springs, keeps volume, E [Pa], nu, alpha [1/s], beta [s], time step [s]
///         springs is an index into spring_names(). Reply: time step, the longest one, the critical one at rest,
///         the longest one while something is pressed [s], number of springs, the longest step while masses of stiff
///         parts are as they are [s], what decides the longest one: see Chosen
///     2, tool, target (3) [m], radius [m], node, number of steps
///         Reply: time [s], tool (3) [m], force (3) [N], middle (3) [m] and radius [m] of the round load that the
///         tractions of a pull are the means of over facets (core/load_case.hpp), radius 0 of those of a probe,
///         which are even on each facet,
///         indentation [m], smallest volume, largest speed [m/s], restarts, seconds that the steps took, evaluations of
///         all forces, which are more than steps where some were divided, N, K, L; node
///         (K), force (K,3) [N], facet (L), traction (L,3) [Pa]; and as float32 displacement (N,3) [m]
///     3
///         back to rest, and whole. Reply: empty
///     4
///         keeps the state, in place of the one that was kept before. Reply: empty
///     5
///         back to the state that was kept, and to the body as it was then. Reply: empty
///     6, entry (3), target (3) [m], diameter [m], spread [m], toughness [J/m^2], friction [N/m], puncture force [N],
///     depth [m], number of steps
///         a needle, see core/tool/needle/needle.hpp. Reply: its depth, tip [m], force of the hand, force at the tip
///         [N], 0 or 1 whether the surface has given way, displacement of the target (3) [m], work of the hand, of
///         friction and of tearing [J], K, forces on the tissue at the places of core::needle_line() (K,3) [N], and all
///         that is said to message 2, where the tool is the tip
///
///     7, whether loose pieces are taken away as well, 0 or 1, what cuts, and its numbers:
///         0, region, margin [m], 0 or 1 whether it is kept everywhere, 0 or 1 whether the capsule is opened for it
///         1, point (3) [m], normal (3)            all to which the normal points
///         2, corners (4,3) [m], thickness [m]     all that a straight blade touches; without thickness it parts
///         a cut, see Scene::cut(); what there was before is kept as by 4. Reply: volume taken, of the way to the
///         surface among it [m^3], area of the wound [m^2], margin left around the lesions [m], no number if none was
///         cut; volume of closed cavities [m^3] and their depth below the surface [m]; of a wound that is parted, mean
///         and largest distance from the blade [m], before nodes went to the blade and after; loose pieces taken,
///         pieces left; seconds to find what goes, to find how long steps may be, of springs and of all; K, T, P, Q;
///         tetrahedra (K) that are gone by now, of the body; its boundary now, triangles (T,3) and what each is (T): 0
///         free, 1 constrained, 2 free and in the wound; and of what is parted by now, nodes that are new or in other
///         places (P): number, place at rest (3) [m], node of the body that it is or was parted from; and tetrahedra
///         (Q): number, nodes (4). Facets of a later reply to message 2 are numbers of these triangles.
///     8, place (3) [m], inwards (3), target (3) [m], radius [m], depth [m], number of steps
///         a grasp of two balls, see live::Jaws: the first is put to the place of the surface, the other to where the
///         way inwards from there leaves the body; each closes by the depth, and both are led by the way from the place
///         to the target. Reply: the depth that they have reached [m], force of each along the axis, the mean of both
///         [N], centre of the other one (3) [m], force on it (3) [N], and all that is said to message 2, where the tool
///         is the centre of the first one, and the force that on both together
///     9, target (3) [m], inwards (3), half a side [m], number of steps
///         a square plate with rounded edges, see live::shape_of(), whose centre is led to the target and whose axis is
///         the way inwards. Reply: as to message 2
///
/// @return bytes
/// @throws support::InputError for any other message, or for what Scene refuses
std::string reply(Scene &scene, std::span<const double> message);

/// spring_names() in the order of their numbers, with commas between them.
std::string joined_spring_names();

} // namespace livermark::live
