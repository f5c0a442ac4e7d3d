#pragma once

#include <array>
#include <vector>

#include "core/mesh/places.hpp"
#include "core/problem.hpp"
#include "core/tool/touching_tool.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// Pressures that follow the surface of a body (LoadCase::follows) on its nodes: a third of -p a goes to each corner of
/// a facet, with a the area vector that it has now.
///
/// Around nodes that have facets with one pressure all around, that is minus the derivative of the energy
///     sum over the facets of p / 6 (x_1 x x_2) . x_3,
/// p times the volume below the surface. At the rim of the place it is not, and there is no energy.
class SurfacePressure {
  public:
    explicit SurfacePressure(const core::Problem &problem);

    bool is_empty() const { return facets_.empty(); }

    /// @param positions  shape (N) [m], here and below
    /// @return [J]
    double energy(const Field &positions) const;

    /// Adds the derivative of the energy to nodal forces.
    void add_gradient(const Field &positions, Field &gradient) const;

    /// Forces on the nodes at the rim beyond minus that derivative; zero on others.
    /// @return shape (N) [N]
    Field rim_force(const Field &positions) const;

    /// @return shape (N) [N], what the facets are pushed with where they are
    Field force(const Field &positions) const;

  private:
    struct Facet {
        std::array<int, 3> nodes;
        double pressure; ///< [Pa], positive inwards
    };
    std::vector<Facet> facets_;
    core::Vector3 origin_ = core::Vector3::Zero(); ///< that volumes are measured from [m]
};

/// Contact of a surface with the ball of LoadCase::touching: the law of core::ContactLaw at points x = sum N_k x_k of
/// its facets, with N the linear shape functions and with the area a of the surface at rest that each point stands for.
/// Forces go to the corners by N.
///
/// Within an equilibrium it is an energy, so that any search for a minimum finds it:
///     sum over the points of a (p^2 / (2 eps) + phi(|s|)),
///     phi(s) = eps_t s^2 / 2 where eps_t s <= b, else b s - b^2 / (2 eps_t),
/// with s the way of the point from its anchor across a normal. The normal and the bound b = mu p of friction are those
/// of the equilibrium before: equilibria follow one another until pressures are what these were found with. Then
/// friction is Coulomb's. (Simo, Laursen 1992, section 3; the fixed bound is Tresca's friction, N. Kikuchi, J. T. Oden
/// 1988, Contact Problems in Elasticity, chapter 10)
class SurfaceContact {
  public:
    /// Nothing touches yet.
    explicit SurfaceContact(const core::Problem &problem, const core::FacetSoftness &softness = {});

    /// Whether the load case has no ball.
    bool is_empty() const { return facets_.empty(); }

    /// Puts the ball where it is at a part of its way, with the penalties that facets have there.
    void move_ball(double part);

    /// @param positions  shape (N) [m], here and below
    /// @return [J]
    double energy(const Field &positions) const;

    /// Rounding of the energy [J] by that of distances from the centre of the ball: a ball of 30 m that stands for a
    /// flat rounds them by 7e-15 m.
    double rounding_of_energy(const Field &positions) const;

    /// Adds the derivative of the energy to nodal forces.
    void add_gradient(const Field &positions, Field &gradient) const;

    /// Second derivative of the energy; entries of all nodes that may touch are there, and of all pairs on a facet.
    /// @param tangent  exact, or else without what makes it less than positive semi-definite
    /// @return shape (3N, 3N) [N/m]
    Eigen::SparseMatrix<double> hessian(const Field &positions, Tangent tangent) const;

    /// product += hessian u, exact.
    void add_hessian_product(const Field &positions, const Eigen::VectorXd &u, Eigen::VectorXd &product) const;

    /// Takes normals and bounds of friction from an equilibrium.
    /// @param part  of the change of bounds that is taken, (0, 1]: less than all where equilibria go to and fro
    /// @return by how much forces on points change by all of that, over all of them: sum of |change| over sum of
    /// |force|
    double update(const Field &positions, double part = 1.0);

    /// Ends a step of the load: anchors are dragged along where points slip, and go with points that do not touch.
    void end_step(const Field &positions);

    /// Forces on the body [N], of the ball and of the other jaw if there is one.
    std::vector<core::Vector3> forces(const Field &positions) const;

    /// By how much the deepest point is inside the ball [m], >= 0.
    double depth(const Field &positions) const;

  private:
    struct Point {
        double area = 0.0; ///< [m^2]
        core::ContactMemory memory;
        core::Vector3 normal = core::Vector3::Zero(); ///< that friction is across
        double bound = 0.0;                           ///< b [Pa]
    };
    /// Points that the same nodes carry.
    struct Facet {
        core::TouchedFacet touched;
        core::ContactLaw law;
        std::size_t first = 0; ///< in points_; as many as shapes_ has
        bool is_for_other_jaw = false;
        bool remembers = false; ///< whether a point has a bound that is not zero
    };
    struct Friction {
        double energy = 0.0;                                 ///< phi [J/m^2]
        core::Vector3 traction = core::Vector3::Zero();      ///< minus its derivative [Pa]
        Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero(); ///< its second derivative [Pa/m], positive semi-definite
    };
    using Block = Eigen::Matrix<double, 9, 9>;

    core::Vector3 centre_for(const Facet &facet) const;
    core::Vector3 from_centre(const Facet &facet, const std::array<double, 3> &shape, const Field &positions) const;
    bool may_matter(const Facet &facet, const Field &positions) const;
    template <class Visit> void visit(const Field &positions, const Visit &visit) const;
    core::Contact normal_contact(const Facet &facet, const Point &point, const core::Vector3 &from_centre) const;
    Friction friction(const Facet &facet, const Point &point, const core::Vector3 &from_centre) const;
    core::Vector3 traction(const Facet &facet, const Point &point, const core::Vector3 &from_centre) const;
    Eigen::Matrix3d stiffness(const Facet &facet, const Point &point, const core::Vector3 &from_centre,
                              Tangent tangent) const;
    Block block(const Facet &facet, const Field &positions, Tangent tangent) const;

    core::TouchingTool ball_;
    std::vector<core::FacetPoint> shapes_; ///< of the points of each facet
    std::vector<Facet> facets_;
    std::vector<Point> points_;
    core::Vector3 centre_ = core::Vector3::Zero();
    std::size_t num_nodes_ = 0; ///< N
};

} // namespace livermark::msm
