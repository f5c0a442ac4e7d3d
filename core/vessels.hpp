#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

struct Body;

/// Vessels that are thinner than the elements of a mesh, as lines through it: a tree of tubes that move with the tissue
/// around them. Six fibres around each axis have the energy E A / 12 (s - 1)^2 per length, s their stretch: a tube
/// resists stretch and bending, and not what flattens or blows it up. Blood has no stiffness, and the tissue in its
/// place is taken off, so that E A = E_w pi (r^2 - (r - t)^2) - E pi r^2, and no less than nothing. (Embedded
/// reinforcement: Phillips and Zienkiewicz 1976, Proc. Inst. Civ. Eng. 61)
struct VesselTree {
    std::vector<Vector3> points;              ///< (V) of the axes at rest [m]
    std::vector<double> radius;               ///< (V) r, outer [m], > 0
    std::vector<std::array<int, 2>> segments; ///< (W) straight pieces between two of the points; r is their mean
    double wall_ratio = 0.0;                  ///< t / r, in (0, 1]
    double wall_modulus = 0.0;                ///< E_w along the tube [Pa], > 0

    /// E A of a segment in tissue of a Young's modulus [N].
    double axial_stiffness(std::size_t segment, double young_modulus) const;
    /// Length of a segment [m].
    double length(std::size_t segment) const;
    bool operator==(const VesselTree &) const = default;
};

/// Point of integration on a vessel.
struct VesselPoint {
    int tetrahedron = 0;
    Eigen::Vector4d coordinates; ///< barycentric
    Vector3 direction;           ///< of the fibre at rest, length 1
    double weight = 0.0;         ///< E A of the fibre times the length that the point stands for [N m]

    /// Derivative of the energy weight / 2 (s - 1)^2 by the stretch, as a vector along the moved axis [N m].
    /// @param moved  F times the direction
    Vector3 pull(const Vector3 &moved) const;
    double energy(const Vector3 &moved) const; ///< [J]
    /// Second derivative by the moved axis [N m]: the exact one, whose part across a tube that is pressed is negative.
    Eigen::Matrix3d stiffness(const Vector3 &moved) const;
};

/// The points of the vessels of a body, in the order of its tetrahedra: where a fibre passes a tetrahedron, the two of
/// Gauss's rule there, which is exact for what quadratic elements make of small strains. Fibres stand where the second
/// moment of the wall is theirs, and are moved by a millionth of the size of the tree, so that none lies in a face.
/// What is outside the body has no points.
/// @return empty where the body has no vessels
std::vector<VesselPoint> vessel_points(const Body &body);

/// Part of the length of the vessels of a body that lies inside it, from 0 to 1.
/// @param body  with vessels
double part_inside(const Body &body);

} // namespace livermark::core
