#pragma once

#include <functional>
#include <vector>

#include "live/surface.hpp"

namespace livermark::live {

/// A rigid sphere without friction.
struct Sphere {
    core::Vector3 centre = core::Vector3::Zero(); ///< [m]
    double radius = 0.0;                          ///< [m]
};

/// Where a node is now [m].
using PositionOf = std::function<core::Vector3(int node)>;

/// Triangles that a sphere can reach before anything has moved by the margin, given where everything is now.
std::vector<int> near_triangles(const Surface &surface, const Sphere &sphere, double margin,
                                const PositionOf &position_of);

/// Pressure that grows with how deep the surface is in the sphere, over each triangle as the sum over 16 equal parts of
/// it, each pushed away from the centre at its middle:
///   f = p A_part (r - |x - c|) (x - c) / |x - c|   where |x - c| < r.
/// It is the gradient of an energy, so it adds none to the motion. Triangles whose outside looks away from the sphere
/// are on the far side of the body, and are left alone.
/// @param triangles  of near_triangles()
/// @param modulus    p [Pa/m]
/// @param load       what it is added to
void add_contact(const Surface &surface, const std::vector<int> &triangles, const Sphere &sphere, double modulus,
                 const PositionOf &position_of, Load &load);

} // namespace livermark::live
