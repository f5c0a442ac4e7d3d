#pragma once

#include <array>
#include <vector>

#include "interactive/elements/energies.hpp"
#include "interactive/scene.hpp"

namespace livermark::interactive {

/// A tetrahedron with ten nodes: the corners of a linear one, and the middles of its edges in the order of
/// core::tetrahedron_edges. It has straight edges at rest, so its deformation gradient is linear in it: that at a
/// quadrature point is a mean of those at the corners,
///     F(corner k) = (3 x_k (x) d_k + sum over the other corners j of (4 x_kj - x_j) (x) d_j),
/// with d the gradients of the linear shape functions and x_kj the middle of the edge from k to j.
struct QuadraticTetrahedron {
    static constexpr int num_points = 4; ///< of the quadrature

    /// Matrices at the corners or the quadrature points.
    using AtPoints = std::array<Matrix3, num_points>;

    std::array<int, 10> nodes;
    Matrix3 inverse_edges; ///< of Tetrahedron, B [1/m]
    double volume;         ///< at rest [m^3]
    double mu, lambda;     ///< Lame parameters [Pa]

    /// Volume of a quadrature point [m^3].
    double weight() const { return volume / num_points; }

    /// F at the quadrature points.
    AtPoints gradients(const Field &x) const;

    /// f -= sum over the points of weight P grad N [N], with P the first Piola-Kirchhoff stress [Pa].
    void add_forces(const AtPoints &stresses, Field &f) const;

    /// Gradients of the ten shape functions at rest at a quadrature point, shape (10, 3) [1/m].
    Eigen::Matrix<double, 10, 3> shape_gradients(int point) const;

    /// Second derivatives at x of its neo-Hookean energy, of component c of node a at 3 a + c [N/m].
    /// @param is_projected  whether those of each point are made positive semidefinite
    Eigen::Matrix<double, 30, 30> stiffness(const Field &x, bool is_projected) const;
};

/// W = sum over the quadrature points of weight times the neo-Hookean density. The rule has four points, exact to
/// degree 2: what other codes take for quadratic tetrahedra.
/// (P. C. Hammer, A. H. Stroud 1956, Numerical integration over simplexes, Math. Tables Aids Comput. 10)
class QuadraticEnergy : public Energy {
  public:
    /// @param scene  of quadratic_scene()
    explicit QuadraticEnergy(const Scene &scene);

    double value(const Field &x) const override;
    void add_forces(const Field &x, Field &f) const override;
    void add_hessian(const Field &x, bool is_projected, Triplets &triplets) const override;

    const std::vector<QuadraticTetrahedron> &tetrahedra() const { return tetrahedra_; }

  private:
    std::vector<QuadraticTetrahedron> tetrahedra_;
};

/// A scene on linear tetrahedra with a node in the middle of each edge: edge e of core::edge_table() has node N + e.
/// Those on a boundary triangle whose corners are all constrained are so too, as in finite elements whose facets are.
/// Masses are lumped in proportion to the diagonal of the consistent matrix, a 36th of a tetrahedron's mass at a
/// corner and four 27ths at an edge, all positive (Hinton, Rock, Zienkiewicz 1976, Earthq. Engng Struct. Dyn. 4). A
/// tetrahedron's mass is what it has of the masses of its corners by its volume.
/// Dead forces stay at the corners, where they come in.
Scene quadratic_scene(Scene scene);

} // namespace livermark::interactive
