#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/load_case.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"
#include "core/tool/touching_tool.hpp"
#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/material_law.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/linear/facets.hpp"

namespace livermark::hyperelastic {

/// Minus the derivatives of forces on the surface by displacements, one small matrix for each facet, in two parts: a
/// symmetric one that stands in the stiffness, and so in what preconditions it, and the rest, which products add.
class SurfaceStiffness {
  public:
    struct OfFacet {
        std::vector<int> nodes;
        Eigen::MatrixXd symmetric, rest; ///< shape (3 k, 3 k) [N/m], unknown 3 a + i of its k nodes
    };
    void add(OfFacet facet) { facets_.push_back(std::move(facet)); }

    /// Adds the symmetric parts.
    void add_to(fem_reference::SymmetricBlocks<double> &stiffness) const;
    /// out += the rest times x
    /// @param x, out  shape (3 n)
    void add_product(std::span<const double> x, std::span<double> out) const;

  private:
    std::vector<OfFacet> facets_;
};

/// A pressure that stays perpendicular to the surface as it moves, and acts on its deformed area:
///     f_a = - integral over the triangle of p N_a x_r cross x_s dr ds,   x = X + u,
/// with r and s the coordinates on the unit triangle. The integrals are exact.
/// (K. Schweizerhof, E. Ramm 1984, Displacement dependent pressure loads in nonlinear finite element analyses, Comput.
/// Struct. 18(6))
class FollowerPressure {
  public:
    /// @param system    kept alive and unchanged by the caller
    /// @param mesh      that it was assembled on
    /// @param pressure  shape (T) [Pa], positive inwards, 0 where there is none; or empty
    /// @throws std::invalid_argument if it has another size
    FollowerPressure(const fem_reference::ElasticSystem &system, const core::TetraMesh &mesh,
                     std::span<const double> pressure);

    /// @param factor        that pressures are multiplied by
    /// @param displacement  shape (3 n) [m]
    /// @param force         shape (3 n) [N], added to
    void add_forces(double factor, const std::vector<double> &displacement, std::vector<double> &force) const;

    /// The derivatives of minus the forces. They are not symmetric: a surface whose edge is free or sees the pressure
    /// end there has no potential. The symmetric halves stand in the stiffness.
    SurfaceStiffness load_stiffness(double factor, const std::vector<double> &displacement) const;

  private:
    struct Facet {
        std::vector<int> nodes; ///< corners as in the mesh, then the middles of 01 12 20
        double pressure;        ///< [Pa]
    };
    const fem_reference::ElasticSystem *system_;
    std::vector<Facet> facets_;
    fem_reference::ReferenceTriangle reference_;
};

/// Parameters of contact.
struct ContactSettings {
    /// Penalty eps over E / sqrt(R d) with the largest Young's modulus E of the body, the radius R of the ball and its
    /// depth d, or over E / a with the size a of a plate: either sinks in by about 1 / stiffness of its depth beyond
    /// the surface.
    double stiffness = 100.0;
    double sunk_in = 1e-3;     ///< of the depth, weighted with pressure, where augmentation ends
    int max_augmentations = 4; ///< at each point of the path
    /// Softness of facets of linear functions, in place of the stiffness. It does not fade.
    std::optional<core::FacetSoftness> softness{};
};

/// Settings for elements of a degree: below a ball linear ones have the softness of tetrahedra. A flat face of a plate
/// needs none on flat facets.
ContactSettings contact_settings(int degree, const core::ToolShape &shape);

/// Points that touch at a state.
struct TouchSums {
    core::Vector3 force = core::Vector3::Zero();       ///< on the body [N], of the ball
    core::Vector3 other_force = core::Vector3::Zero(); ///< of the other jaw, if there is one [N]
    core::Vector3 friction = core::Vector3::Zero();    ///< of both by friction [N]
    double area = 0.0;                                 ///< of the surface at rest [m^2]
    double slipping_area = 0.0;                        ///< of that [m^2]
    double sunk_in = 0.0;                              ///< penetration in the mean weighted with pressure [m]
    /// sqrt(5/2) times the distance from the axis through the centre of the ball along its press, in the quadratic mean
    /// weighted with pressure: of Hertz's pressure the radius of contact [m].
    double radius = 0.0;
};

/// A rigid tool that touches a body (core::TouchingTool): the integrals
///     f_a = integral over the surface at rest of N_a (p n + tau) dA
/// at the seven points of ReferenceTriangle on each facet that may touch, with core::touch() at x = X + u. Pressures
/// are on the area at rest. Multipliers of augmentation and anchors of friction are kept at the points.
class TouchingBall {
  public:
    /// @param system  kept alive and unchanged by the caller
    /// @param body, load_case  that it was assembled on; with a ball that touches
    TouchingBall(const fem_reference::ElasticSystem &system, const core::Body &body, const core::LoadCase &load_case,
                 const ContactSettings &settings = {});

    const core::TouchingTool &tool() const { return tool_; }
    const ContactSettings &settings() const { return settings_; }

    /// @param centre        where the ball is [m]
    /// @param displacement  shape (3 n) [m]
    /// @param force         shape (3 n) [N], added to
    void add_forces(const core::Vector3 &centre, std::span<const double> displacement,
                    std::vector<double> &force) const;
    /// The derivatives of minus the forces. Curvature and slip take no more than the largest pressure, so that Newton's
    /// method has a direction where the ball has moved and the body not yet.
    /// @param expected  shape (num_points()) [Pa], of expected_pressure(): what the curvature of the ball takes where
    ///   the pressure is more; or empty, and the derivatives are exact up to the largest pressure
    void add_stiffness(const core::Vector3 &centre, std::span<const double> displacement, SurfaceStiffness &stiffness,
                       std::span<const double> expected = {}) const;
    /// The pressure that the tangent expects after a change of the displacement, max(0, p - eps n . du), at points that
    /// touch before it, and zero at others. A small step along the ball makes the pressure of a stiff penalty
    /// much larger than that, so that the curvature of a tangent with it is wrong, and large enough to make the tangent
    /// indefinite. Newton's method converges in fewer iterations where the tangent has the expected one (D. Magisano,
    /// L. Leonetti, G. Garcea 2017, How to improve efficiency and robustness of the Newton method in geometrically
    /// non-linear structural problem discretized via displacement-based finite elements, Comput. Methods Appl. Mech.
    /// Eng. 313).
    /// @param change  shape (3 n) [m]; or empty for none
    /// @return shape (num_points()) [Pa]
    std::vector<double> expected_pressure(const core::Vector3 &centre, std::span<const double> displacement,
                                          std::span<const double> change = {}) const;
    TouchSums sums(const core::Vector3 &centre, std::span<const double> displacement) const;

    /// Pressures become multipliers (Uzawa), so that the ball sinks in less.
    void augment(const core::Vector3 &centre, std::span<const double> displacement);
    /// Stick and slip are kept for the steps to come.
    void end_step(const core::Vector3 &centre, std::span<const double> displacement);

    std::size_t num_points() const { return memory_.size(); } ///< of all facets that may touch

  private:
    struct Facet {
        std::vector<int> nodes;
        double area; ///< [m^2]
        bool is_for_other_jaw;
        core::ContactLaw law;
    };
    template <class Visit>
    void visit(const core::Vector3 &centre, std::span<const double> displacement, const Visit &visit) const;

    const fem_reference::ElasticSystem *system_;
    core::TouchingTool tool_;
    ContactSettings settings_;
    double largest_pressure_ = 0.0; ///< below a ball that has not gone through the body [Pa]
    std::vector<Facet> facets_;
    fem_reference::ReferenceTriangle reference_;
    std::vector<core::ContactMemory> memory_; ///< (facets, points)
};

/// dW / dF of the whole energy, including the volume term: first Piola-Kirchhoff stress [Pa].
/// @param f  det F > 0
Matrix3 whole_stress(const MaterialLaw &law, const core::Material &material, const Matrix3 &f);

/// d2 W / dF2 of the whole energy, including the volume term.
/// @param f  det F > 0
/// @return [Pa]
Tangent whole_tangent(const MaterialLaw &law, const core::Material &material, const Matrix3 &f);

/// Resistance of an evenly deformed half space to short waves of its surface, when the tractions on the surface keep
/// their direction and size per area at rest. A wave a exp(i k t . x) of the surface, and below it what has the least
/// energy, takes the energy k / 2 a* Z a per area, with the surface impedance Z of the direction t. Where Z is not
/// positive definite, waves grow by themselves, however short they are: no mesh resolves them, and finer meshes find
/// equilibria of lower energy, or none (the complementing condition fails; H. C. Simpson, S. J. Spector 1987, On the
/// positivity of the second variation in finite elasticity, Arch. Ration. Mech. Anal. 98). Without a traction that is
/// M. A. Biot's limit (1963, Surface instability of rubber in compression, Appl. Sci. Res. A 12). Z is
/// H^-1 + i H^-1 S, with the matrices S and H of D. M. Barnett and J. Lothe (1973, Synthesis of the sextic and the
/// integral formalism for dislocations, Greens functions, and surface waves in anisotropic elastic solids, Phys. Norv.
/// 7).
/// @param tangent  d2 W / dF2 [Pa], also of other moduli
/// @param normal   of the surface at rest, outwards, of length 1
/// @return least eigenvalue of Z, over 12 directions t [Pa]; NaN where the material itself is not elliptic
double least_surface_impedance(const Tangent &tangent, const Eigen::Vector3d &normal);

/// The body at the centroid of a boundary triangle.
struct SurfacePoint {
    core::Vector3 at_rest; ///< [m]
    core::Vector3 normal;  ///< at rest, outwards, of length 1
    double area = 0.0;     ///< of the triangle at rest [m^2]
    Matrix3 deformation;   ///< F
    core::Material material;
};

/// @param displacement  shape (3 n) [m], of quadratic elements
/// @return shape (T)
std::vector<SurfacePoint> surface_points(const Elements &elements, std::span<const double> displacement);

/// F of a surface whose stretches and shears along itself are these, and on which a traction acts: what is across the
/// surface follows from P N = t. It has none of the error of a pressure that is not that of F, as in mixed elements.
/// @param traction  t, per area at rest [Pa]
/// @return not finite where no such F is found
Matrix3 under_traction(const MaterialLaw &law, const SurfacePoint &point, const core::Vector3 &traction);

/// Part of the area under tractions that keep their direction, where the surface cannot resist short waves (see
/// least_surface_impedance()): the problem itself has no stable solution there, whatever the mesh.
/// @param load_case  on the mesh of the elements, which are quadratic
/// @param factor     that its tractions are multiplied by: a fraction of the load, or newtons where places press
/// @return 0 where there are no such tractions
double unstable_part(const Elements &elements, const core::LoadCase &load_case, std::span<const double> displacement,
                     double factor);

} // namespace livermark::hyperelastic
