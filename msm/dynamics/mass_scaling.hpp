#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/problem.hpp"
#include "msm/elastic_body.hpp"

/// Selective mass scaling: a stiff inclusion, say a tumour, is given more mass for its fast deformations, so that
/// explicit steps may be as long as those of the tissue around it. With Q the projection onto what is left alone, rigid
/// motions of the inclusion where it is and its slow deformations turned with it, orthogonal in its masses M, and a
/// factor f >= 1,
///   a = c + (Q + (I - Q) / f) (M^-1 F - c),   so the mass is M (Q + f (I - Q)) for what is seen from the inclusion,
/// where c are the centripetal and Coriolis accelerations of an inclusion that turns.
/// Forces and torques on the inclusion are as before, and so linear and angular momentum of the body are kept to
/// rounding, and every equilibrium stays. What changes is how fast the inclusion deforms, which it hardly does.
/// (Olovsson, Simonsson, Unosson 2005, Int. J. Numer. Meth. Engng. 63, scale the mass of each element so; one
/// projection for a whole inclusion has an inverse in closed form.)
namespace livermark::msm {

/// Nodes that move nearly as a rigid body, n of them.
struct ScaledRegion {
    std::vector<int> nodes; ///< at least 4, free in all components
    double factor = 1.0;    ///< f, >= 1
    Eigen::VectorXd mass;   ///< (n) [kg]
    Eigen::Matrix3Xd rest;  ///< (3, n) at rest, from the centre of mass [m]
    /// (3n, m) slow deformations about rest: orthonormal in the masses and orthogonal to rigid motions [kg^-1/2]
    Eigen::MatrixXd slow;
};

/// No node is in two parts.
struct MassScaling {
    std::vector<ScaledRegion> parts; ///< none: nothing is scaled
};

/// Nodes of each connected part of a body that is stiffer than most of it: of regions whose (lambda + 2 mu) / density
/// is more than twice that of the region of the largest volume.
/// @return ascending; none for a body of one material
std::vector<std::vector<int>> stiff_parts(const core::Body &body);

/// Scales the stiff parts so that each alone, with all other nodes constrained, has no higher frequency than the rest
/// of the body has with the stiff parts constrained: f = (omega_part / omega_rest)^2. Slow deformations are those
/// linear and quadratic fields of a part that, by Ritz's method, have a frequency below 0.9 omega_rest. Parts that need
/// no scaling are left out.
/// @param springs     of the body
/// @param conditions  constrained nodes belong to no part
MassScaling scale_masses(const core::Body &body, const ElasticBody &springs, const NodalConditions &conditions);

/// The same factors where more is constrained. A part that loses nodes has no slow deformations any more.
MassScaling constrained(const MassScaling &scaling, const NodalConditions &conditions);

/// Rotation of a part since rest, of its moment sum of m x rest^T with x and rest from their centres of mass.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d &moment);

/// Takes what a field does besides moving a part as a rigid body, or slowly deforming it, times a factor. Its momentum
/// and angular momentum about any point stay as they are.
/// @param x       shape (3, n), where the nodes are [m], not all on a line
/// @param factor  > 0
/// @param field   shape (3, n), velocities, accelerations or small displacements
void scale_deformation(const ScaledRegion &part, const Eigen::Matrix3Xd &x, double factor, Eigen::Matrix3Xd &field);

/// The same of all parts, each with f^power.
/// @param x, field   shape (3N)
void scale_deformation(const MassScaling &scaling, double power, const Eigen::VectorXd &x, Eigen::VectorXd &field);

/// From accelerations M^-1 F to those of the scaled masses.
/// @param x, v          shape (3, n), positions [m] and velocities [m/s]
/// @param acceleration  shape (3, n) [m/s^2]
void scale_acceleration(const ScaledRegion &part, const Eigen::Matrix3Xd &x, const Eigen::Matrix3Xd &v,
                        Eigen::Matrix3Xd &acceleration);

/// The same of all parts.
/// @param x, v, acceleration  shape (3N)
void scale_acceleration(const MassScaling &scaling, const Eigen::VectorXd &x, const Eigen::VectorXd &v,
                        Eigen::VectorXd &acceleration);

} // namespace livermark::msm
