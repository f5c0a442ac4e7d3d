#pragma once

#include <vector>

#include "core/problem.hpp"
#include "core/tool/touching_tool.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// Contact of the nodes of a surface with the ball of LoadCase::touching: the law of core::ContactLaw at each node,
/// with the area a that the node has at rest, a third of each facet around it that the ball may touch.
///
/// Within an equilibrium it is an energy, so that any search for a minimum finds it:
///     sum over the nodes of a ((p^2 - lambda^2) / (2 eps) + phi(|s|)),
///     phi(s) = eps_t s^2 / 2 where eps_t s <= b, else b s - b^2 / (2 eps_t),
/// with s the way of the node from its anchor across a normal. The normal and the bound b = mu p of friction are those
/// of the equilibrium before, and so is lambda, the augmented Lagrangian's multiplier: equilibria follow one another
/// until pressures are what these were found with. Then friction is Coulomb's, and the depth of nodes inside the ball
/// is zero but for the tolerance. (Simo, Laursen 1992, section 3; the fixed bound is Tresca's friction, N. Kikuchi,
/// J. T. Oden 1988, Contact Problems in Elasticity, chapter 10)
class SurfaceContact {
  public:
    /// Where it is larger, fewer equilibria follow one another, and each is harder to find.
    static constexpr double usual_stiffness = 10.0;

    /// Nothing touches yet.
    /// @param stiffness  penalty eps in Young's moduli over the mean edge of the facets
    explicit SurfaceContact(const core::Problem &problem, double stiffness = usual_stiffness);

    /// Whether the load case has no ball.
    bool is_empty() const { return nodes_.empty(); }

    /// Puts the ball where it is at a part of its way.
    void move_ball(double part);

    /// @param positions  shape (N) [m], here and below
    /// @return [J]
    double energy(const std::vector<core::Vector3> &positions) const;

    /// Adds the derivative of the energy to nodal forces.
    void add_gradient(const std::vector<core::Vector3> &positions, std::vector<core::Vector3> &gradient) const;

    /// Second derivative of the energy, blocks of nodes; entries of all nodes that may touch are there.
    /// @param tangent  exact, or else without what makes it less than positive semi-definite
    /// @return shape (3N, 3N) [N/m]
    Eigen::SparseMatrix<double> hessian(const std::vector<core::Vector3> &positions, Tangent tangent) const;

    /// product += hessian u, exact.
    void add_hessian_product(const std::vector<core::Vector3> &positions, const Eigen::VectorXd &u,
                             Eigen::VectorXd &product) const;

    /// Takes multipliers, normals and bounds of friction from an equilibrium.
    /// @param part  of the change of bounds that is taken, (0, 1]: less than all where equilibria go to and fro
    /// @return by how much forces on nodes change by all of that, over all of them: sum of |change| over sum of |force|
    double update(const std::vector<core::Vector3> &positions, double part = 1.0);

    /// Ends a step of the load: anchors are dragged along where nodes slip, and go with nodes that do not touch.
    void end_step(const std::vector<core::Vector3> &positions);

    /// What the ball exerts on the body [N].
    core::Vector3 force(const std::vector<core::Vector3> &positions) const;

    /// By how much the deepest node is inside the ball [m], >= 0.
    double depth(const std::vector<core::Vector3> &positions) const;

  private:
    struct Node {
        int node = 0;
        double area = 0.0; ///< [m^2]
        core::ContactMemory memory;
        core::Vector3 normal = core::Vector3::Zero(); ///< that friction is across
        double bound = 0.0;                           ///< b [Pa]
    };
    struct Friction {
        double energy = 0.0;                                 ///< phi [J/m^2]
        core::Vector3 traction = core::Vector3::Zero();      ///< minus its derivative [Pa]
        Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero(); ///< its second derivative [Pa/m], positive semi-definite
    };

    core::Vector3 from_centre(const Node &node, const std::vector<core::Vector3> &positions) const;
    core::Contact normal_contact(const Node &node, const core::Vector3 &from_centre) const;
    Friction friction(const Node &node, const core::Vector3 &from_centre) const;
    Eigen::Matrix3d block(const Node &node, const core::Vector3 &from_centre, Tangent tangent) const;

    core::TouchingTool ball_;
    core::ContactLaw law_; ///< of pressure and friction
    std::vector<Node> nodes_;
    core::Vector3 centre_ = core::Vector3::Zero();
    std::size_t num_nodes_ = 0; ///< N
};

} // namespace livermark::msm
