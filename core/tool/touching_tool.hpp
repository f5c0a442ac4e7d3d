#pragma once

#include <array>
#include <limits>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"

namespace livermark::core {

/// Distance of a point of the body from a tool, with the point p of its flat that is nearest to x, or of what is behind
/// the flat of a plate; that of a ball is its centre c.
struct Gap {
    double size = 0.0;                ///< g = |x - p| - R [m], below 0 inside the tool
    Vector3 normal = Vector3::Zero(); ///< n = (x - p) / |x - p|, out of the tool and into the body
    double distance = 0.0;            ///< |x - p| [m]; before or behind the face of a plate R
};

/// Behind the face of a plate the gap goes on as before it: g = h - R and n the axis, with the height h above the flat.
/// @param from_centre  d = x - c, of a point of the body and the centre of the tool [m]; of a ball not zero
Gap gap_to(const ToolShape &shape, const Vector3 &from_centre);

/// Derivative of the normal times the distance, I - n n^T - dp/dx: symmetric, and zero on the face of a plate.
Eigen::Matrix3d bend(const ToolShape &shape, const Vector3 &from_centre, const Gap &gap);

/// Whether a point is outside a tool by a margin, or more.
inline bool is_outside(const ToolShape &shape, const Vector3 &from_centre, double margin = 0.0) {
    const double reach = shape.radius + margin;
    return shape.is_plate() ? gap_to(shape, from_centre).size >= margin : from_centre.squaredNorm() >= reach * reach;
}

/// The law of contact at one point, in displacement and traction; at a node that stands for an area, multiply penalties
/// by the area, and pressures and tractions are forces.
///
/// Pressure is that of an augmented Lagrangian, p = max(0, lambda - eps g), and the whole traction on the body is
/// p n + tau. Friction holds each point to an anchor a on the tool with tau' = -eps_t (I - n n^T) (d - a), as long as
/// |tau'| <= mu p; beyond that the point slips with tau = mu p tau' / |tau'|, and the anchor is dragged along.
/// (J. C. Simo, T. A. Laursen 1992, An augmented Lagrangian treatment of contact problems involving friction, Comput.
/// Struct. 42(1); P. Wriggers, Computational Contact Mechanics, 2006, chapters 6 and 10)
struct ContactLaw {
    double penalty = 0.0;            ///< eps [Pa/m], > 0
    double tangential_penalty = 0.0; ///< eps_t [Pa/m], > 0
    double friction = 0.0;           ///< mu, >= 0
};

/// Memory of one point of the surface from one step of the load to the next.
struct ContactMemory {
    double multiplier = 0.0;          ///< lambda [Pa]: 0 is a pure penalty
    Vector3 anchor = Vector3::Zero(); ///< a [m], from the centre of the tool; at first where the point is at rest
};

/// Effect of the tool on one point.
struct Contact {
    Gap gap;
    double pressure = 0.0;              ///< p [Pa], >= 0
    Vector3 friction = Vector3::Zero(); ///< tau on the body [Pa], along the surface of the tool
    bool slips = false;                 ///< it touches and |tau'| > mu p

    bool touches() const { return pressure > 0.0; }
    Vector3 traction() const { return pressure * gap.normal + friction; } ///< on the body [Pa]
};

/// @param from_centre  d [m], of a ball not zero
Contact touch(const ContactLaw &law, const ToolShape &shape, const Vector3 &from_centre, const ContactMemory &memory);

/// Energy of the pressure alone: (p^2 - lambda^2) / (2 eps) [J/m^2]. Its derivative by d is -p n.
double contact_energy(const ContactLaw &law, const Contact &contact, const ContactMemory &memory);

/// Minus the derivative of the traction by d [Pa/m], in two parts.
struct ContactStiffness {
    Eigen::Matrix3d positive = Eigen::Matrix3d::Zero(); ///< symmetric, no eigenvalue below 0: what preconditioners take
    Eigen::Matrix3d rest = Eigen::Matrix3d::Zero();     ///< curvature of the tool, and slip that pressure allows

    Eigen::Matrix3d all() const { return positive + rest; }
};

/// Zero where the point does not touch. The same parameters as of touch(), which gave the contact.
ContactStiffness contact_stiffness(const ContactLaw &law, const ToolShape &shape, const Vector3 &from_centre,
                                   const ContactMemory &memory, const Contact &contact);

/// Memory of a point when a step of the load has found its equilibrium: the anchor where it sticks, the dragged one
/// where it slips, its own place where it does not touch. The multiplier stays.
ContactMemory after_step(const ContactLaw &law, const Vector3 &from_centre, const ContactMemory &memory,
                         const Contact &contact);

/// Compliance c h (1 - nu^2) / E of an area below a ball, by which linear functions on a facet of side h cannot give
/// way, with
///     c(xi) = max(c_0 exp(-(xi / x_0)^2), least),   xi = a / h.
/// A body that gives way by Hertz's displacements on a half-space does so within a facet as well, and one of linear
/// functions does not. It is too stiff where the circle of contact, of radius a, is small beside the facets, and less
/// so the more facets there are in it. How much depends on how a body takes strains from its tetrahedra: docs/studies/
/// contact.md has the constants and the half-space on which they were chosen.
struct FacetSoftness {
    double at_first = 0.1;                                     ///< c_0 > 0
    double fades_at = std::numeric_limits<double>::infinity(); ///< x_0 > 0; infinity where it stays
    static constexpr double least = 0.01;                      ///< beyond it nothing changes but condition numbers

    /// @param circle_over_side  xi
    double at(double circle_over_side) const;
    bool operator==(const FacetSoftness &) const = default;
};

/// Softness of bodies whose strains are those of tetrahedra alone, as of linear elements.
inline constexpr FacetSoftness softness_of_tetrahedra{.at_first = 0.42};

/// A flat facet that a tool may touch.
///
/// Facets are flat, and a body of linear functions cannot follow a ball within them. A penalty in 1 / h stands for
/// that: it goes with the mesh as the error of the functions does, so that the whole converges to contact without
/// penetration (F. Chouly, P. Hild 2013, On convergence of the penalty method for unilateral contact problems, Appl.
/// Numer. Math. 65), where facets without penetration are too stiff on coarse meshes.
struct TouchedFacet {
    std::array<int, 3> nodes{};
    double area = 0.0;                ///< at rest [m^2]
    Vector3 normal = Vector3::Zero(); ///< at rest, out of the body
    double side = 0.0;                ///< h, the mean of its sides [m]
    double modulus = 0.0;             ///< E / (1 - nu^2) of what is behind it [Pa]
    FacetSoftness softness{};

    /// eps = E / ((1 - nu^2) h c) [Pa/m]
    /// @param circle  radius of what the tool touches [m]
    double penalty(double circle) const { return modulus / (side * softness.at(circle / side)); }
    /// The same of friction, which stays: a point that sticks keeps its force as the tool sinks in.
    double tangential_penalty() const { return penalty(0.0); }
};

/// The facets of LoadCase::may_touch(), in the order of the mesh.
std::vector<TouchedFacet> touched_facets(const Body &body, const LoadCase &load_case,
                                         const FacetSoftness &softness = {});

/// Radius of what a tool touches at a part of its way [m]: see ToolShape::contact_radius().
double circle_of_contact(const TouchingTool &tool, double part);

/// Parts of a side that facet_points() divides these facets into: their sides are at most ToolShape::contact_radius().
int contact_divisions(const Body &body, const LoadCase &load_case);

} // namespace livermark::core
