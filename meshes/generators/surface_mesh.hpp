#pragma once

#include <Eigen/Geometry>
#include <functional>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

/// A closed triangulated surface.
struct SurfaceMesh {
    std::vector<core::Vector3> points;         ///< [m]
    std::vector<std::array<int, 3>> triangles; ///< right-handed seen from outside
};

/// Negative inside a body, positive outside.
using LevelFunction = std::function<double(const core::Vector3 &)>;

/// Brings a point near a surface onto it.
using Projection = std::function<core::Vector3(const core::Vector3 &)>;

/// Volume enclosed by a surface [m^3].
double enclosed_volume(const SurfaceMesh &surface);

/// The zero surface of a level function by marching tetrahedra (six to a cube): closed, oriented, as fine as the grid
/// and with triangles of any shape.
/// @param low, high  corners of a box that holds the body [m]
/// @param spacing    edge of the cubes [m]
SurfaceMesh march_tetrahedra(const LevelFunction &level, const core::Vector3 &low, const core::Vector3 &high,
                             double spacing);

/// The same surface in nearly equilateral triangles of nearly one edge length, by rounds of splitting long edges,
/// collapsing short ones, flipping towards six triangles per node and moving the nodes along the surface (Botsch and
/// Kobbelt 2004, A remeshing approach to multiresolution modeling). No randomness: the same input gives the same
/// output.
/// @param edge  wanted edge length [m]
SurfaceMesh remesh(const SurfaceMesh &surface, const Projection &project, double edge);

/// An icosahedron with every edge cut into `frequency` parts and its nodes on the unit sphere: 20 frequency^2
/// triangles.
SurfaceMesh geodesic_sphere(int frequency);

} // namespace livermark::meshes
