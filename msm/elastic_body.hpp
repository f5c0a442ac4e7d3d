#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "core/tool/stepper.hpp"
#include "core/tool/touching_tool.hpp"

namespace livermark::msm {

struct StepParts;

/// Part of the second derivative of an energy to keep.
enum class Tangent {
    exact,         ///< all of it
    semi_definite, ///< without the part that compression makes negative
    material       ///< only what is left at rest: sum of c w w^T, where c w (w . u) are the forces of small strains
};

/// Tetrahedra of a body after cuts, by the numbers that they and nodes keep, see cutting/cut_parts.hpp.
struct CutTetrahedra {
    const Eigen::VectorXd &rest;                  ///< (3N) nodes at rest [m]
    const std::vector<std::array<int, 4>> &nodes; ///< (M)
    const std::vector<char> &is_removed;          ///< (M)
};

/// One part of the elastic energy of a body, say its springs, or what its volume resists. One file each. Vectors are of
/// 3N components, 3 i + component for node i: positions x [m] and velocities v [m/s].
class ElasticTerm {
  public:
    virtual ~ElasticTerm() = default;

    /// U(x) [J]
    virtual double energy(const Eigen::VectorXd &x) const = 0;

    /// force -= grad U(x) + beta K_m(x) v, with K_m the material tangent: elastic forces, and dashpots that act along
    /// the same strains (Rayleigh damping by the stiffness) [N]. The slow, obvious kernel; every fast one is tested
    /// against it.
    /// @param v  not looked at where beta is zero
    virtual void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                           Eigen::VectorXd &force) const = 0;

    /// force -= grad U(x), and U(x) for little more: for searches that look at both at each place.
    /// @return U(x) [J]; where it is infinite the force stays as it is
    virtual double add_force_and_energy(const Eigen::VectorXd &x, Eigen::VectorXd &force) const;

    /// Second derivative of U at x, both triangles, entries in the same places for every x and tangent.
    /// @return shape (3N, 3N) [N/m]
    virtual Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, Tangent tangent) const = 0;

    /// product += the exact hessian(x) u. Terms that couple many nodes do it without the matrix, which is wide.
    virtual void add_hessian_product(const Eigen::VectorXd &x, const Eigen::VectorXd &u,
                                     Eigen::VectorXd &product) const;

    /// Adds to the 3 x 3 block of each node what bounds the material tangent at x from above: u^T K_m u <= sum over
    /// nodes of u_i^T B_i u_i for all u.
    /// @param blocks  shape (N) [N/m]
    virtual void add_block_bound(const Eigen::VectorXd &x, std::vector<Eigen::Matrix3d> &blocks) const = 0;

    /// Puts down what the fast kernels have to know of this term.
    /// @return false if they do not know such a term
    virtual bool describe(StepParts & /*parts*/) const { return false; }

    /// Whether it acts on few nodes, so that fast kernels may leave it to add_force() in each step.
    virtual bool is_beside_kernels() const { return false; }

    /// The same term of what cuts have left; null where it is not beside the kernels, which then follow themselves.
    virtual std::shared_ptr<const ElasticTerm> after_cut(const CutTetrahedra & /*left*/) const { return nullptr; }
};

/// Point masses with an elastic energy between them. Copies share the terms, which never change.
struct ElasticBody {
    ElasticBody(std::vector<double> node_mass, std::vector<std::shared_ptr<const ElasticTerm>> terms);
    /// Springs are such a body.
    ElasticBody(const core::SpringNetwork &springs); // NOLINT(google-explicit-constructor)

    /// One term more, whose second derivative has few entries, and is that at rest where it is asked for at no
    /// positions.
    void add(const std::shared_ptr<const ElasticTerm> &term);

    std::vector<double> node_mass;                         ///< (N) [kg]
    std::vector<std::shared_ptr<const ElasticTerm>> terms; ///< the energy is their sum
    /// Stiffness at rest that is near that of the terms but has far fewer entries, for factors in place of it, where a
    /// part of the stresses that relax is left: shape (3N, 3N) [N/m]. Null where the terms' own has few.
    std::function<Eigen::SparseMatrix<double>(double part)> preconditioner;
    core::FacetSoftness softness{}; ///< of its facets below a tool
};

/// Elastic energy.
/// @param positions  shape (N) [m]
/// @return [J]
double elastic_energy(const ElasticBody &body, const std::vector<core::Vector3> &positions);

/// Gradient of the elastic energy: the force that holds each node where it is.
/// @param positions  shape (N) [m]
/// @return shape (N) [N]
std::vector<core::Vector3> elastic_gradient(const ElasticBody &body, const std::vector<core::Vector3> &positions);

struct EnergyAndGradient {
    double energy = 0.0;                 ///< [J]
    std::vector<core::Vector3> gradient; ///< (N) [N]; where the energy is infinite it says nothing
};

/// Both at once.
/// @param positions  shape (N) [m]
EnergyAndGradient elastic_energy_and_gradient(const ElasticBody &body, const std::vector<core::Vector3> &positions);

/// Second derivative of the elastic energy, rows and columns 3 i + component.
/// @param positions  shape (N) [m]
/// @return shape (3N, 3N) [N/m], both triangles
Eigen::SparseMatrix<double> elastic_hessian(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                                            Tangent tangent);

/// The elastic forces at rest in proportion to small displacements, term by term and without a matrix.
class StiffnessProduct {
  public:
    /// @param positions  shape (N) of rest [m]
    StiffnessProduct(const ElasticBody &body, const std::vector<core::Vector3> &positions);
    /// K u with K the second derivative of the energy at rest. There the dashpots of a term act as K would.
    /// @param displacement  shape (3N), in any unit
    Eigen::VectorXd times(const Eigen::VectorXd &displacement) const;

  private:
    Eigen::VectorXd forces(const Eigen::VectorXd &velocity) const;

    std::vector<std::shared_ptr<const ElasticTerm>> terms_;
    Eigen::VectorXd rest_;    // (3N) [m]
    Eigen::VectorXd at_rest_; // (3N) what rounding leaves there [N]
};

/// A vector for each node, shape (N).
using Field = std::vector<core::Vector3>;

/// A nodal field as 3N components, and back.
Eigen::VectorXd to_unknowns(const std::vector<core::Vector3> &field);
std::vector<core::Vector3> to_field(const Eigen::VectorXd &unknowns);

/// Positions of nodes that are displaced, shape (N) [m].
std::vector<core::Vector3> moved(const std::vector<core::Vector3> &positions,
                                 const std::vector<core::Vector3> &displacement);

/// The part of a node.
inline auto node_part(const Eigen::VectorXd &field, int node) {
    return field.segment<3>(3 * static_cast<Eigen::Index>(node));
}
inline auto node_part(Eigen::VectorXd &field, int node) {
    return field.segment<3>(3 * static_cast<Eigen::Index>(node));
}

/// A term whose forces take long, and that can work out once what depends on where the body is and not on how it moves.
class FixableTerm {
  public:
    virtual ~FixableTerm() = default;

    /// The same term where the body stays: add_force() gives the same bits in less time. To be asked at no other
    /// positions.
    /// @param x  shape (3N) [m]
    virtual std::shared_ptr<const ElasticTerm> fixed_at(const Eigen::VectorXd &x) const = 0;
};

/// A term of which some stresses relax, one by one where they are: s, with strains e that they do work on. The stress
/// of the elastic law is s_e(x) + s(x), where s_e stays. What relaxes in which term, see core::PronySeries:
///
/// - Springs: the whole tension of each along itself [N]. All springs with one part, so the body keeps the Poisson's
///   ratio of its lattice, and its bulk modulus fades with its shear modulus. That is not what the series says of
///   tissue, but springs alone cannot do better.
/// - Springs coupled around nodes, around edges or inside tetrahedra: of each mean the second Piola-Kirchhoff stress
///   that resists changes of shape, in the six components of tetrahedron.hpp [Pa]. Its pressure stays, also that of
///   means of F, where the stress turns with the body.
/// - Volumes (springs/springs.hpp) and the guard against inversion are no such terms: they stay elastic. Beside central
///   springs they hold lambda - mu alone, so of the bulk modulus lambda + 2/3 mu the springs' part of 5/3 mu fades.
class RelaxingTerm : public ElasticTerm {
  public:
    /// s at positions x, all behind each other.
    /// @return shape (S), here and below
    virtual Eigen::VectorXd relaxing_stress(const Eigen::VectorXd &x) const = 0;

    /// force -= sum over S of stress (d e / dx): what such stresses do to the nodes [N].
    virtual void add_force_of(const Eigen::VectorXd &x, const Eigen::VectorXd &stress,
                              Eigen::VectorXd &force) const = 0;

    /// Factor with which the square of a stress is twice its energy, at rest: the volume over 2 mu, or
    /// one over the stiffness of a spring [J], per squared unit of s.
    virtual Eigen::VectorXd relaxing_compliance() const = 0;

    /// The same term with the stresses s_e + part s + added. It has the energy U_e + part U_s + sum of added e. What
    /// relaxes of it is part s.
    /// @param part   what is left of s, not negative
    /// @param added  does not depend on x; if empty, nothing
    virtual std::shared_ptr<const RelaxingTerm> relaxed(double part, const Eigen::VectorXd &added) const = 0;
};

/// Measure of the deformation that coupled springs average (springs/springs.hpp).
enum class StrainMeasure {
    elongation,          ///< of the edges: E is linear in q = 2 l0 (l - l0), see springs/tetrahedron.hpp
    cauchy_green,        ///< C = F^T F, linear in the squared lengths of the edges: E is linear in q = l^2 - l0^2
    deformation_gradient ///< F: E = (F^T F - I) / 2 is taken of the mean of F
};

/// A measure g of a relative change of volume e = J - 1, with g = 0 and g' = 1 where there is none.
struct VolumeMeasure {
    double value;     ///< g
    double slope;     ///< g'
    double curvature; ///< g''
};
using MeasureVolume = VolumeMeasure (*)(double change);

/// g = e
VolumeMeasure change_of_volume(double change);
/// g = ln (1 + e), minus infinity where no volume is left
VolumeMeasure logarithm_of_volume(double change);

struct EnergyFunctions;

/// Parts of a body that fast kernels know how to move: springs, springs coupled around nodes or around edges, the
/// volume around nodes or of tetrahedra, and the guard against inversion, as plain arrays. Empty arrays stand for a
/// part that is not there.
struct StepParts {
    std::vector<std::array<int, 2>> edges; ///< (S) node numbers
    std::vector<double> stiffness;         ///< (S) [N/m]
    std::vector<double> rest_length;       ///< (S) [m]

    std::vector<std::array<int, 4>> tetrahedra; ///< (M) node numbers, of all that follows
    /// (M) pressure of a tetrahedron for each m^3 that it has gained [Pa/m^3]
    std::vector<double> tetrahedron_stiffness;
    /// (C) node in the middle of each control volume, to which every tetrahedron in it gives a quarter of its own
    std::vector<int> centre;
    std::vector<double> volume_stiffness;          ///< (C) pressure for each m^3 that it has gained [Pa/m^3]
    std::vector<std::array<int, 4>> corner_volume; ///< (M) control volume around each corner
    MeasureVolume resisted_change = nullptr; ///< g of all volumes that are resisted; null as long as there are none
    bool averages_volumes = false;           ///< see mean_volumes_around_nodes()

    StrainMeasure measure = StrainMeasure::elongation; ///< of springs that are coupled
    /// Whether springs are coupled by means of C or F, which keep strains and their rates apart.
    bool has_means_of_tensors() const { return measure != StrainMeasure::elongation; }
    EnergyFunctions (*kernels)() = nullptr;  ///< of the energy of coupled springs; null if there are none
    MeasureVolume beside = change_of_volume; ///< g of the energy, which the volumes beside such springs have
    /// (C) shear modulus of the springs that are coupled in each control volume [Pa]
    std::vector<double> coupled_modulus;
    /// (E) shear modulus of the springs that are coupled around each edge, in each of the materials there [Pa]; in
    /// place of coupled_modulus
    std::vector<double> edge_modulus;
    std::vector<std::array<int, 6>> edge_part; ///< (M) which of them, in the order of core::tetrahedron_edges
    std::vector<double> inner_modulus;         ///< (M) of those that stay inside each tetrahedron [Pa]
    /// (M) shear modulus of each tetrahedron [Pa]: coupled_modulus and edge_modulus are its means by volume times
    /// part_of_means. Empty where those of a region are one.
    std::vector<double> tetrahedron_modulus;
    double part_of_means = 0.0;          ///< of the stiffness of coupled springs
    std::vector<double> least_volume;    ///< (M) [m^3] below which a tetrahedron is pushed back
    std::vector<double> guard_stiffness; ///< (M) pressure for each m^3 that it then lacks [Pa/m^3]
    std::vector<double> watched_volume;  ///< (M) see FastStepOptions [m^3]
    /// (M) tetrahedra that a cut has taken away and that are still in their places here, empty if none are: see
    /// cutting/cut_parts.hpp. They have no volume and no stiffness.
    std::vector<char> is_removed;
    bool is_there(std::size_t tetrahedron) const { return is_removed.empty() || is_removed[tetrahedron] == 0; }
};

/// Puts down where control volumes around nodes are.
/// @return false if another term has already put down others
bool describe_volumes(const std::vector<int> &centre, const std::vector<std::array<int, 4>> &corner_volume,
                      StepParts &parts);

/// A body whose terms are parted by who moves them.
struct PartedTerms {
    ElasticBody in_kernels;
    std::vector<std::shared_ptr<const ElasticTerm>> beside; ///< see ElasticTerm::is_beside_kernels()
};

PartedTerms part_terms(const ElasticBody &body);

/// @return nothing if the body has a part that fast kernels do not know
std::optional<StepParts> step_parts(const ElasticBody &body);

/// Node masses by barycentric lumping: m_i = 1/4 sum over the tetrahedra t at node i of rho_t V(t)
/// (equation 2 of Jurnal Teknologi 75, 10.11113/jt.v75.5068).
/// @return shape (N) [kg]; the sum is the mass of the body
std::vector<double> lumped_masses(const core::Body &body);

using core::NodalConditions;

/// Conditions of nodes that are all free and that nothing pulls.
NodalConditions free_nodes(std::size_t num_nodes);

/// Takes the conditions of a load case from its facets to the nodes: a third of each facet's traction to its corners,
/// the acceleration by node mass. Where several constraints meet at a node, each component takes value and reaction
/// from the constraint of lowest index that prescribes it.
/// @param node_mass  shape (N) [kg]
NodalConditions nodal_conditions(const core::Problem &problem, const std::vector<double> &node_mass);

/// Sums nodal forces over each constraint.
/// @param conditions  of the problem
/// @param force       shape (N) [N], what the constraints exert on each node
/// @param press       what the places that press exert together [N]
/// @param touch       what each of LoadCase::contacts() exerts [N]; or empty
/// @return shape (P) [N]
std::vector<core::Vector3> constraint_forces(const core::Problem &problem, const NodalConditions &conditions,
                                             const std::vector<core::Vector3> &force, double press = 0.0,
                                             const std::vector<core::Vector3> &touch = {});

} // namespace livermark::msm
