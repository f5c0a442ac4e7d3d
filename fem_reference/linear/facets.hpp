#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/problem.hpp"
#include "fem_reference/linear/elastic_system.hpp"

/// Facets of elements: their nodes, their shape functions, the membrane that covers them, and the springs below them.
namespace livermark::fem_reference {

/// Lagrange elements on the unit triangle at the points of a quadrature rule. Nodes are corners, then midpoints of
/// 01 12 20.
struct ReferenceTriangle {
    std::vector<double> weight;             ///< (Q) they sum to 1/2
    std::vector<Eigen::VectorXd> shape;     ///< (Q) values, shape (nodes)
    std::vector<Eigen::Matrix2Xd> gradient; ///< (Q) shape (2, nodes)
};

/// With seven points, exact to degree 5: the follower loads of quadratic elements have degree 4.
/// @param degree  1 or 2
ReferenceTriangle reference_triangle(int degree);

/// The nodes of a boundary triangle in the order of ReferenceTriangle, corners as the mesh has them.
std::vector<int> nodes_of_facet(const ElasticSystem &system, const core::TetraMesh &mesh, std::size_t facet);

/// Adds a small symmetric matrix of some nodes to a stiffness that has entries for each pair of them.
/// @param matrix  shape (3 k, 3 k), unknown 3 a + i of the k nodes
void add_to(SymmetricBlocks<double> &stiffness, std::span<const int> nodes, const Eigen::MatrixXd &matrix);

/// The capsule of a body (core::Capsule) on the facets of its elements: total Lagrangian, with
/// F = sum over nodes of (X_a + u_a) (grad N_a)^T, the gradient in the plane of the membrane at rest. At rest it goes
/// through the nodes of the mesh and is curved between them (core::SmoothSurface), so that midpoints of quadratic
/// facets have places X_a of their own: on flat facets a membrane would only pull at their edges, and what it does to a
/// ball under pressure would be wrong by 10 % where R is 5 edges.
class Membrane {
  public:
    /// Covers nothing where the body has no capsule.
    Membrane(const core::Body &body, const ElasticSystem &system);

    /// force += dW/du.
    /// @param displacement  u of the elements' nodes, shape (3 n) [m]
    /// @param force         shape (3 n) [N]
    /// @param energy_share  shape (M) which part of the energy of the facets of each tetrahedron counts; empty for all
    /// @return W [J]
    double add_force(std::span<const double> displacement, std::span<double> force,
                     std::span<const double> energy_share = {}) const;

    /// stiffness += d2W/du2, which compression makes indefinite.
    /// @param displacement  shape (3 n) [m]; empty for the body at rest
    void add_stiffness(std::span<const double> displacement, SymmetricBlocks<double> &stiffness) const;

  private:
    struct Facet {
        std::vector<int> nodes;
        int tetrahedron = 0;   ///< whose face it is
        Eigen::Matrix3Xd rest; ///< X of its nodes [m]
    };
    struct Point;
    Point at_point(const Facet &facet, std::size_t q, std::span<const double> displacement) const;

    double modulus_ = 0.0; ///< E t / 3, the shear modulus times the thickness [N/m]
    ReferenceTriangle reference_;
    std::vector<Facet> facets_;
};

/// The springs of a foundation (core::Foundation) below the facets of elements, whose shape functions they move with:
/// W = 1/2 u . K u, K_(ai)(bj) = sum over facets of k_ij times the integral of N_a N_b at rest. They are linear, and
/// their energy is not one of the body.
class FoundationSprings {
  public:
    /// Nothing where there is no foundation.
    /// @param foundation  on facets of the mesh
    FoundationSprings(const std::optional<core::Foundation> &foundation, const core::TetraMesh &mesh,
                      const ElasticSystem &system);

    /// force += K u.
    /// @param displacement  u of the elements' nodes, shape (3 n) [m]
    /// @param force         shape (3 n) [N]
    void add_force(std::span<const double> displacement, std::span<double> force) const;

    /// W [J]
    double energy(std::span<const double> displacement) const;

    /// stiffness += K.
    void add_stiffness(SymmetricBlocks<double> &stiffness) const;

  private:
    struct Facet {
        std::vector<int> nodes;
        Eigen::MatrixXd stiffness; ///< shape (3 k, 3 k) [N/m], unknown 3 a + i of its k nodes
    };

    std::vector<Facet> facets_;
};

} // namespace livermark::fem_reference
