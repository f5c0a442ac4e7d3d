#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

struct Body;

/// Smooth surface through the nodes of the covered facets of a mesh, which are flat themselves: a membrane on them
/// would not resist what moves the middle of a facet outwards, and would pull at its edges alone.
struct SmoothSurface {
    std::vector<Vector3> normal; ///< (N) outwards, of length 1; zero inside, and where the surface has an edge
    /// (N) of the surface from each node: zero, but for those that refinement put on facets [m]
    std::vector<Vector3> offset;

    /// Offset of the surface from the middle between two nodes that an edge of facets joins [m]: of the cubic with the
    /// directions of the surface at both ends, (t_a - t_b) / 8 with t the edge in the plane of each end. (Vlachos,
    /// Peters, Boyd, Mitchell 2001, Curved PN triangles, I3D). Straight towards an end without a normal.
    Vector3 offset_between(const TetraMesh &mesh, int a, int b) const;
    /// Normal there; zero where an end has none.
    Vector3 normal_between(const TetraMesh &mesh, int a, int b) const;
};

/// Normals are means over the covered facets at a node, by area. Where one of them is more than 40 degrees off that,
/// the surface has an edge: so has a right angle, whose facets are 45 degrees off.
SmoothSurface smooth_surface(const TetraMesh &mesh);

/// Membrane on the surface of a body, such as Glisson's capsule of a liver: it stretches and does not bend. It is
/// incompressible and neo-Hookean, of the energy E t / 6 (tr C + 1 / det C - 3) per area at rest with the Cauchy-Green
/// tensor C in the plane of the surface: at small strains E t / 3 (e : e + (tr e)^2), a plane stress with Poisson's
/// ratio 1/2. Its mass is left out.
struct Capsule {
    double thickness = 0.0;     ///< t at rest [m], > 0
    double young_modulus = 0.0; ///< E at small strain [Pa], > 0

    /// E t, the tension per width of a strain along one direction [N/m].
    double stiffness() const { return young_modulus * thickness; }
    /// It covers all of the boundary but what cuts have opened.
    static bool covers(const TetraMesh &mesh, int facet) {
        return !is_in_patch(mesh.patch_names[static_cast<std::size_t>(mesh.boundary_patch[facet])], wound_patch);
    }
    bool operator==(const Capsule &other) const {
        return thickness == other.thickness && young_modulus == other.young_modulus;
    }

    /// The surface on a mesh that is refined; null where it is that of smooth_surface().
    std::shared_ptr<const SmoothSurface> surface{};
};

/// The surface of the capsule of a body. @throws std::bad_optional_access if it has none
std::shared_ptr<const SmoothSurface> capsule_surface(const Body &body);

/// The same after edges of the mesh have been split.
/// @param split   ends of the edge of each new node, which stand behind those of the coarse body
/// @param points  of the refined mesh, wherever the new nodes are [m]
std::shared_ptr<const SmoothSurface> refined_surface(const Body &coarse, std::span<const std::array<int, 2>> split,
                                                     std::span<const Vector3> points);

/// Springs that stand for the capsule of a body: what they add to the stiffness of each edge,
///     k_ij = sum over the covered facets at edge ij of sqrt 3 / 4 E t.
/// It is found as Lloyd's formula for solids is: three equal springs on a regular triangle of side l have, at a strain
/// e, the energy sum over their directions n of k l^2 / 2 (n . e n)^2 = 3 / 16 k l^2 (2 e : e + (tr e)^2). Over the
/// area sqrt 3 / 4 l^2 that is a plane stress with Poisson's ratio 1/3 and E t = 4 / sqrt 3 k. The capsule has 1/2, so
/// these springs are right along one direction, 12.5 % too stiff in shear, and 25 % too soft where it grows in both.
/// @param edges  of the body's mesh
/// @return shape (S) [N/m]; zeros where the body has no capsule
std::vector<double> capsule_springs(const Body &body, const EdgeTable &edges);

} // namespace livermark::core
