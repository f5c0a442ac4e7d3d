#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/problem.hpp"
#include "fem_reference/hyperelastic/material_law.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/linear/facets.hpp"
#include "fem_reference/linear/vessel_lines.hpp"

namespace livermark::hyperelastic {

/// Lagrange elements on the unit tetrahedron (corners 0, e_x, e_y, e_z) at the points of a quadrature rule. Nodes are
/// in the order of fem_reference::ElasticSystem::cell_nodes.
struct ReferenceTetrahedron {
    std::vector<double> weight;                ///< (Q) they sum to 1: parts of the volume
    std::vector<Eigen::Matrix3Xd> gradient;    ///< (Q) of the shape functions, one per column, shape (3, nodes)
    std::vector<Eigen::Vector4d> linear_shape; ///< (Q) values of the four linear shape functions
};

/// Number of points that integrate over a tetrahedron.
enum class TetrahedronRule {
    one_point,      ///< exact to degree 1: all there is to integrate on linear elements
    four_points,    ///< exact to degree 2: what other codes take for quadratic elements
    fourteen_points ///< exact to degree 5 (Witherden and Vincent 2015, Comput. Math. Appl. 69(10))
};

/// @param degree  1 or 2
ReferenceTetrahedron reference_tetrahedron(int degree, TetrahedronRule rule);

/// Part that relaxation adds to the energy per volume of a point in one time step:
///     - faded W_s(F') + 1/2 H : (C' - I),   F' = J^(-1/3) F,   C' = F'^T F',
/// so that the isochoric part of the law is multiplied by 1 - faded = core::instant_part(), and what the branches
/// remember pushes along: a potential, although relaxation has none over several steps.
/// (J. C. Simo 1987, On a fully three-dimensional finite-strain viscoelastic damage model, Comput. Methods Appl. Mech.
/// Eng. 60; Simo and Hughes, Computational Inelasticity, 1998, section 10.3)
struct IsochoricPart {
    const MaterialLaw &law;
    const core::Material &material;
    double faded;
    const Matrix3 &remembered; ///< H, symmetric [Pa]

    /// [Pa]
    /// @param f  det F > 0, here and below
    double energy(const Matrix3 &f) const;
    /// Its derivative by F [Pa].
    Matrix3 stress(const Matrix3 &f) const;
    /// Its second derivative [Pa].
    Tangent tangent(const Matrix3 &f) const;
};

/// Stress that the branches follow: the deviator S - (S : C') / 3 C'^-1 of S = 2 d W_s / dC' at C', symmetric [Pa]. At
/// small strains twice the shear modulus times the deviatoric strain.
Matrix3 isochoric_stress(const MaterialLaw &law, const core::Material &material, const Matrix3 &f);

/// A time step at all points of integration of a body.
struct DeviatoricMemory {
    double faded = 0.0;                ///< 1 - core::instant_part()
    std::vector<Matrix3> remembered{}; ///< H at each point, cell by cell: sum over branches of fade h(n) - gain s(n)
};

/// Unknowns; n is the number of nodes, m that of pressures.
struct State {
    std::vector<double> displacement; ///< (3 n) u [m]
    std::vector<double> pressure;     ///< (m) p [Pa], positive where the body is dilated
};

/// Energy and forces of a state.
struct InternalForces {
    double smallest_jacobian = 0.0; ///< of all points of integration; if it is not positive, nothing else is set
    double energy = 0.0;            ///< [J]
    std::vector<double> force;      ///< (3 n) derivative of the energy by the displacements [N]
    std::vector<double> imbalance;  ///< (m) derivative of the energy by the pressures [m^3]
};

/// Derivatives of InternalForces: [K D^T; D -C] with the constant C of Elements.
struct TangentMatrices {
    fem_reference::SymmetricBlocks<double> stiffness; ///< (3 n, 3 n) K [N/m]
    fem_reference::DivergenceRows<double> divergence; ///< (m, 3 n) D [m^2]
};

/// Total Lagrangian finite elements of a hyperelastic body, on straight tetrahedra of its shape at rest.
///
/// In displacements alone their energy is
///     Pi(u) = integral of W_s(F) + k / 2 g(J)^2,   F = I + grad u,   J = det F.
/// The mixed formulation has a pressure in regions that are nearly incompressible (fem_reference::PressureSystem), with
/// quadratic displacements the elements of Taylor and Hood, and looks for the saddle point of
///     Pi(u, p) = integral of W_s(F) + p g(J) - p^2 / (2 k),
/// the perturbed Lagrangian. Its p = k g(J) at every point would be the same energy; p is the linear interpolation of
/// that, and so the elements do not lock.
/// The capsule of a body adds the energy of its Membrane to both, and its vessels that of VesselLines.
/// (T. Sussman, K.-J. Bathe 1987, A finite element formulation for nonlinear incompressible elastic and inelastic
/// analysis, Comput. Struct. 26)
class Elements {
  public:
    /// @param body    tetrahedra of positive volume, every node used
    /// @param degree  1 or 2
    /// @param law     kept alive by the caller
    /// @param rule    where the energy is evaluated; linear elements in displacements alone need one point
    /// @throws std::invalid_argument for another degree, for the mixed formulation of linear elements, or if a
    ///   boundary triangle is not an outer face
    Elements(std::shared_ptr<const core::Body> body, int degree, fem_reference::Formulation formulation,
             const MaterialLaw &law, TetrahedronRule rule);

    const core::Body &body() const { return *body_; }
    const MaterialLaw &law() const { return *law_; }
    int degree() const { return system_.nodes_per_cell == 4 ? 1 : 2; }
    /// Numbering, facets, masses, and the stiffness of linear elasticity (in the mixed formulation without lambda).
    const fem_reference::ElasticSystem &system() const { return system_; }
    const fem_reference::PressureSystem &pressure() const { return pressure_; }
    /// (m, m) C_qr = integral of psi_q psi_r / k [m^3/Pa]
    const fem_reference::SymmetricMatrix &compliance() const { return compliance_; }

    int num_displacements() const { return 3 * system_.num_nodes(); }
    int num_pressures() const { return pressure_.num_pressures(); }

    /// At rest.
    State rest() const;

    /// @param energy_share  shape (M) which part of the energy of each tetrahedron counts; empty where all of it does
    InternalForces internal_forces(const State &state, std::span<const double> energy_share = {}) const;

    /// A matrix of zeros with entries in the right places, to be assembled into.
    TangentMatrices zero_tangent() const;

    /// @param state    of positive smallest_jacobian
    /// @param tangent  of zero_tangent(); overwritten
    void assemble_tangent(const State &state, TangentMatrices &tangent) const;

    /// Lets a body stand on springs, whose forces are added to internal_forces() and whose stiffness is added to
    /// tangents from then on. Energies stay those of the body.
    /// @param foundation  on facets of the body's mesh
    void stand_on(const core::Foundation &foundation);

    /// A body that relaxes: adds IsochoricPart to the energy at each point of integration.
    /// @param memory  of as many points as point_volumes() has; kept alive by the caller; nullptr for none
    void set_memory(const DeviatoricMemory *memory) { memory_ = memory; }
    /// isochoric_stress() at each point of integration, cell by cell.
    /// @param state  of positive smallest_jacobian
    std::vector<Matrix3> isochoric_stresses(const State &state) const;
    /// The volume that each point of integration stands for, cell by cell [m^3].
    std::vector<double> point_volumes() const;

  private:
    struct Cell;
    template <class Action> void for_each_cell(const Action &action) const;
    IsochoricPart isochoric_part(const Cell &cell, std::size_t point) const;

    std::shared_ptr<const core::Body> body_;
    const MaterialLaw *law_;
    fem_reference::ElasticSystem system_;
    fem_reference::PressureSystem pressure_;
    fem_reference::SymmetricMatrix compliance_;
    ReferenceTetrahedron reference_;
    fem_reference::Membrane membrane_;
    fem_reference::VesselLines vessels_;
    const DeviatoricMemory *memory_ = nullptr;
    std::optional<fem_reference::FoundationSprings> foundation_;
    std::vector<int> block_; ///< (M, nodes (nodes - 1) / 2) where the block of two nodes of a cell stands
};

} // namespace livermark::hyperelastic
