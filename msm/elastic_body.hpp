#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "core/solution.hpp"

namespace livermark::msm {

struct StepParts;

/// What of the second derivative of an energy to keep.
enum class Tangent {
    exact,         ///< all of it
    semi_definite, ///< without the part that compression makes negative
    material       ///< only what is left at rest: sum of c w w^T, where c w (w . u) are the forces of small strains
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
};

/// Point masses with an elastic energy between them. Copies share the terms, which never change.
struct ElasticBody {
    ElasticBody(std::vector<double> node_mass, std::vector<std::shared_ptr<const ElasticTerm>> terms);
    /// Springs are such a body.
    ElasticBody(const core::SpringNetwork &springs); // NOLINT(google-explicit-constructor)

    std::vector<double> node_mass;                         ///< (N) [kg]
    std::vector<std::shared_ptr<const ElasticTerm>> terms; ///< the energy is their sum
    /// A term whose second derivative at rest is near that of the sum but has far fewer entries, for factors in place
    /// of it; null where the terms' own has few.
    std::shared_ptr<const ElasticTerm> preconditioner;
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

/// A nodal field as 3N components, and back.
Eigen::VectorXd to_unknowns(const std::vector<core::Vector3> &field);
std::vector<core::Vector3> to_field(const Eigen::VectorXd &unknowns);

/// The part of a node.
inline auto of_node(const Eigen::VectorXd &field, int node) {
    return field.segment<3>(3 * static_cast<Eigen::Index>(node));
}
inline auto of_node(Eigen::VectorXd &field, int node) {
    return field.segment<3>(3 * static_cast<Eigen::Index>(node));
}

} // namespace livermark::msm
